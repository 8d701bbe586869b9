"""The tables and sentences of a report on accuracy and time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pvphong.studies.accuracy.result import Result
from pvphong.studies.accuracy.rows import KINDS, LedgerEntry, Row, Timing
from pvphong.studies.accuracy.timing import FEWEST_REPEATS

if TYPE_CHECKING:
    from rich.table import Table

# Seconds that a call of `mesh.phong.shade` takes beside the lighting, about; see the whole job's times in the README.
_CALL = 1e-3

# Columns of a terminal that names take beside what is said of them.
_NAMES = 24


def everything(result: Result) -> Iterator[Any]:
    """The parts of the whole report, tables and sentences."""
    yield rows_table(result)
    yield from conclusions(result)
    yield ""
    yield ledger_table(result)
    if result.promises:
        yield promises_table(result)
    notes = [(row.name, row.note) for row in result.rows if row.note]
    if notes:
        yield _plain_table("notes", notes)
    if result.left_out:
        yield _plain_table("left out", by_reason(result.left_out))
    told = [*result.facts.items()]
    loudest = max(result.rows, key=lambda row: row.time.spread)
    spread = f"times spread by {result.noise:.1%} of their median, quartile to quartile, in the middle row"
    most = f"by {loudest.time.spread:.0%} in {loudest.name}"
    told.append(("noise", f"{spread}, {most}; differences below that may be none"))
    worst = ", ".join(f"{error:.2g} at vertex {index}" for index, error in result.worst())
    yield _plain_table("measured on", [*told, ("worst vertices", worst)])


HEADINGS = ("", "way", "time", "spread", "largest", "RMS", "99 %", "points")
"""Of `cells`."""


def rows_table(result: Result) -> Table:
    """All rows, by kind and time; ★ is chosen, ● on its kind's front, a dominated one has no mark."""
    title = "What accuracy costs in time: colour errors, each of its row's kind; ★ chosen, ● on the front"
    table = _table(title, *HEADINGS)
    table.padding = 0  # so that every name fits
    for column in table.columns:
        column.no_wrap, column.justify = column.header != "way", "left" if column.header in ("", "way") else "right"
    last = ""
    for row in in_order(result):
        if last != row.kind:
            table.add_section()
            table.add_row("", f"{row.kind}:")
        last = row.kind
        mark, name, *numbers = cells(result, row)
        table.add_row(mark, f" {name}", *numbers)
    return table


def in_order(result: Result) -> list[Row]:
    """The rows by kind, and by time."""
    return sorted(result.rows, key=lambda row: (KINDS.index(row.kind), row.time.median))


def cells(result: Result, row: Row) -> tuple[str, ...]:
    """A row's texts under `HEADINGS`; the spread is from quartile to quartile, as a part of the time."""
    is_chosen = row in result.chosen
    return (
        "★" if is_chosen else "●" if row.on_front else "",
        f"{row.name} (peer)" if row.is_peer else row.name,
        seconds(row.time.median),
        f"{row.time.spread:.0%}",
        *(f"{error:.2g}" for error in (row.error.largest, row.error.rms, row.error.p99)),
        f"{row.points}",
    )


def ledger_table(result: Result) -> Table:
    """What each effect costs."""
    title = f"What each effect costs: time with it minus time without it, of {result.baseline}"
    table = _table(title, "effect", "", "cost", "if dropped", "why")
    for column in table.columns[1:4]:
        column.no_wrap = True
    for column in table.columns[2:4]:
        column.justify = "right"
    for entry in result.ledger:
        table.add_row(entry.effect, "on" if entry.runs else "off", *_cost(entry), entry.why)
    return table


def _cost(entry: LedgerEntry) -> tuple[str, str]:
    error = "" if entry.error is None else number(entry.error)
    if entry.cost is None:
        return "", error
    return "in the noise" if is_noise(entry.cost) else seconds(entry.cost.median), error


def is_noise(cost: Timing) -> bool:
    """Whether a cost, a difference of times, cannot be told from none: by its quartiles, or by too few repeats."""
    return cost.low <= 0.0 or cost.repeats < FEWEST_REPEATS


def promises_table(result: Result) -> Table:
    """Bounds and what came of them."""
    table = _table("What the plan promised, and what came of it", "left out", "how", "promised", "measured")
    for promise in result.promises:
        table.add_row(promise.effect, promise.why, number(promise.promised), number(promise.measured))
    return table


def by_reason(left_out: dict[str, str]) -> list[tuple[str, str]]:
    """One line for all that is left out for the same reason."""
    names: dict[str, list[str]] = {}
    for name, reason in left_out.items():
        names.setdefault(reason, []).append(name)
    return [(", ".join(some), reason) for reason, some in names.items()]


def _plain_table(title: str, rows: list[tuple[str, str]]) -> Table:
    table = _table(title, "", "")
    table.show_header = False
    table.columns[0].max_width = _NAMES
    for row in rows:
        table.add_row(*row)
    return table


def _table(title: str, *headings: str) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in headings:
        table.add_column(heading, overflow="fold")
    return table


def in_short(result: Result) -> list[str]:
    """What to choose in plain words: a few lines that fit a terminal."""
    count = sum(not row.is_peer for row in result.rows)
    found = [f"Cheapest within {number(result.tolerance)}, of {count} ways to light {result.surface.n_points} points:"]
    for question, about in _questions(result):
        chosen = result.best(**about)
        row = chosen or result.nearest(**about)
        error = f"{seconds(row.time.median)}, off by {number(row.decisive_error)}"
        found.append(f"  {question}: {'' if chosen else 'none; nearest '}{row.name}, {error}")
    return [*found, *_beside(result)]


def _beside(result: Result) -> Iterator[str]:
    """Whether others do it for less, and whether it matters."""
    said = []
    for _, about in _questions(result):
        peer = result.cheaper_peer(**about)
        if peer is not None:
            less = " for less" if result.best(**about) else ""
            said.append(f"{peer.name} does it{less}, {seconds(peer.time.median)}")
    if said:
        yield f"Of the peers {'; '.join(said)}."
    slowest = result.slowest()
    if slowest.time.median <= _CALL:
        yield f"On so small a mesh everything is cheap: {seconds(slowest.time.median)} at the vertices at most."


def conclusions(result: Result) -> list[str]:
    """What to choose, at what price, and what the next step would cost: a sentence or two per question."""
    found = [_conclusion(result, question.capitalize(), about) for question, about in _questions(result)]
    return [*found, *_beside(result)]


def _questions(result: Result) -> list[tuple[str, dict[str, bool]]]:
    """What is asked, and what `Result.best` is to be told."""
    kinds = {row.kind for row in result.rows if not row.is_peer}
    questions: list[tuple[str, dict[str, bool]]] = [("at the vertices", {})]
    if "sampling" in kinds:
        questions.append(("casting rays", {"rays": True}))
    if "interpolation" in kinds:
        questions.append(("inside triangles", {"inside": True}))
    return questions


def _conclusion(result: Result, question: str, about: dict[str, bool]) -> str:
    """The cheapest row within the tolerance, and the price of the next."""
    chosen = result.best(**about)
    if chosen is None:
        nearest = result.nearest(**about)
        return (
            f"{question} nothing is within {number(result.tolerance)}; nearest is {nearest.name}: "
            f"{number(nearest.decisive_error)} in {seconds(nearest.time.median)}."
        )
    said = (
        f"{question} {chosen.name} is the cheapest within {number(result.tolerance)}: "
        f"at most {number(chosen.decisive_error)} in {seconds(chosen.time.median)}."
    )
    following = result.next_step(chosen)
    return said if following is None else f"{said} {price(chosen, following)}"


def price(chosen: Row, following: Row) -> str:
    """What a more accurate row costs more, and buys."""
    more = following.time.median - chosen.time.median
    times = chosen.decisive_error / following.decisive_error if following.decisive_error else 0.0
    bought = f"buys {times:.3g}× less error" if times else "buys all of it"
    noisy = ", within the noise" if following.time.low <= chosen.time.high else ""
    return f"Next is {following.name}: +{seconds(more)} {bought}{noisy}."


def seconds(value: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("s", 1.0), ("ms", 1e-3)):
        if abs(value) >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e6:.3g} µs"


def number(value: float) -> str:
    """An error in three digits."""
    return "0" if value == 0.0 else f"{value:.3g}"
