"""The tables and sentences of a report on accuracy and time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from pvphong.studies.accuracy.result import Result
from pvphong.studies.accuracy.rows import Entry, Errors, Row, Timing
from pvphong.studies.accuracy.timing import FEWEST_REPEATS

if TYPE_CHECKING:
    from rich.table import Table


def everything(result: Result) -> Iterator[Any]:
    """The parts of the printed result."""
    yield rows_table(result)
    yield from (f"{sentence}\n" for sentence in conclusions(result))
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


def rows_table(result: Result) -> Table:
    """All rows, by kind and time; ★ is chosen, ● on its kind's front, a dominated one has no mark."""
    headings = ("", "rung", "time", "quartiles", "arithmetic", "light model", "interpolation", "RMS", "99 %")
    table = _table("What accuracy costs in time: largest errors by kind; ★ chosen, ● on the front", *headings)
    for column in table.columns[2:]:
        column.no_wrap, column.justify = True, "right"
    table.add_column("points", justify="right")
    table.add_column("promised", justify="right")
    chosen = [result.best(), result.best(inside=True)]
    last = ""
    for row in sorted(result.rows, key=lambda row: (_KINDS.index(row.kind), row.time.median)):
        if last != row.kind:
            table.add_section()
            table.add_row("", f"{row.kind}:")
        last = row.kind
        table.add_row(*_cells(row, any(row is best for best in chosen)))
    return table


_KINDS = ("arithmetic", "light model", "interpolation")


def _cells(row: Row, is_chosen: bool) -> tuple[str, ...]:
    return (
        "★" if is_chosen else "●" if row.on_front else "",
        f"  {row.name}" + (" (peer)" if row.is_peer else ""),
        seconds(row.time.median),
        f"{seconds(row.time.low)} – {seconds(row.time.high)}",
        *(_largest(errors) for errors in (row.arithmetic, row.light_model, row.interpolation)),
        number(row.error.rms),
        number(row.error.p99),
        f"{row.points}",
        "" if row.promised is None else number(row.promised),
    )


def _largest(errors: Errors | None) -> str:
    return "" if errors is None else number(errors.largest)


def ledger_table(result: Result) -> Table:
    """What each effect costs."""
    headings = ("effect", "", "cost", "quartiles", "error if dropped", "why")
    title = f"What each effect costs: time with it minus time without it, of {result.baseline}"
    table = _table(title, *headings)
    for column in table.columns[2:5]:
        column.justify = "right"
    for entry in result.ledger:
        table.add_row(entry.effect, "on" if entry.runs else "off", *_cost(entry), entry.why)
    return table


def _cost(entry: Entry) -> tuple[str, str, str]:
    error = "" if entry.error is None else number(entry.error)
    if entry.cost is None:
        return "", "", error
    spread = f"{seconds(entry.cost.low)} – {seconds(entry.cost.high)}"
    return ("in the noise" if is_noise(entry.cost) else seconds(entry.cost.median)), spread, error


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
    for row in rows:
        table.add_row(*row)
    return table


def _table(title: str, *headings: str) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for heading in headings:
        table.add_column(heading, overflow="fold")
    return table


def conclusions(result: Result) -> list[str]:
    """What to choose, at what price, and what the next step would cost: a sentence or two per question."""
    questions = [("At the vertices", False)]
    if any(row.kind == "interpolation" for row in result.rows):
        questions.append(("Inside triangles", True))
    return [_conclusion(result, question, inside) for question, inside in questions]


def _conclusion(result: Result, question: str, inside: bool) -> str:
    """The cheapest row within the tolerance, and the price of the next."""
    chosen = result.best(inside=inside)
    if chosen is None:
        nearest = min(
            (row for row in result.rows if (row.kind == "interpolation") is inside and not row.is_peer),
            key=lambda row: row.decisive_error,
        )
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
