"""Whoever listens hears of work that has a name."""

from pvphong.base.text import about, counting, listening


def test_what_is_done_is_told_with_its_name():
    heard = []
    with listening(lambda *told: heard.append(told)):
        with about("digging"):
            count = counting(4)
            count(1)
            count(3)
        counting(4)(4)  # nameless
    with about("digging"):
        counting(4)(4)  # nobody listens
    assert heard == [("digging", 0.25), ("digging", 1.0)]
