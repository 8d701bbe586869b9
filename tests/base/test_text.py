"""Lines and tables of reports, and the progress of long work."""

import pytest
from rich.table import Table

from pvphong.base import text

WORDS = "in all of these lines there is no word longer than the line, nor any that-is-broken-at-its-hyphens"


@pytest.mark.parametrize("width", [50, 80])
def test_sentences_and_tables_fit_and_break_no_word(monkeypatch, width):
    monkeypatch.setattr(text, "WIDTH", width)
    table = Table("a", "b", box=None)
    table.add_row("[b]x :sun:", WORDS)
    shown = text.rendered([WORDS, table, "end"])
    assert max(map(len, shown.splitlines())) <= width
    assert sorted(shown.split()) == sorted([*WORDS.split() * 2, "a", "b", "[b]x", ":sun:", "end"])
    assert shown.endswith("\n\nend")
    assert not any(line.endswith(" ") for line in shown.splitlines())


def test_a_long_sentence_goes_on_indented():
    lines = text.wrapped(f"  {WORDS} {WORDS}")
    assert [len(line) - len(line.lstrip()) for line in lines] == [2] + [4] * (len(lines) - 1)


def test_html_is_escaped_and_has_every_cell():
    html = text.html_table("<b>a & b", ("x", "<i>"), [("1", "<script>"), ('"2"', "")])
    assert html.replace(' style="text-align: left"', "").replace("\n", "") == (
        "<table><caption>&lt;b&gt;a &amp; b</caption><tr><th>x</th><th>&lt;i&gt;</th></tr>"
        "<tr><td>1</td><td>&lt;script&gt;</td></tr><tr><td>&quot;2&quot;</td><td></td></tr></table>"
    )
    assert "<th" not in text.html_table("t", (), [("a",)])


def test_progress_of_work_that_has_a_name_is_reported_to_who_listens():
    heard = []
    with text.listening(lambda *report: heard.append(report)):
        with text.about("digging"):
            count = text.counting(4)
            count(1)
            count(3)
        text.counting(4)(4)  # nameless
    with text.about("digging"):
        text.counting(4)(4)  # nobody listens
    assert heard == [("digging", 0.25), ("digging", 1.0)]


def test_stages_are_parts_of_the_whole():
    heard = []
    with text.listening(lambda what, part: heard.append((what, round(part, 3)))):
        with text.stage("baking", 0.0, 0.5), text.stage("dough", 0.5, 1.0), text.about("kneading"):
            text.counting(2)(1)
        with text.stage("baking", 0.5, 1.0), text.about("oven"):
            text.counting(4)(1)
    assert {what for what, _ in heard} == {"baking"}
    parts = [part for _, part in heard]
    assert parts == [0.0, 0.25, 0.375, 0.5, 0.5, 0.5, 0.625, 1.0]
    with text.stage("baking", 0.0, 1.0), text.about("oven"):
        text.counting(1)(1)  # nothing listens
