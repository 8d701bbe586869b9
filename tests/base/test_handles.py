"""Handles: only attributes that a class declares can be set."""

from typing import ClassVar

import pytest

from pvphong.base.handles import Handle


class Lamp(Handle):
    position: tuple
    _instead: ClassVar = {"colour": "tint", "color": "nothing"}

    def __init__(self):
        self.position = (0, 0, 0)
        self._tint = "red"

    @property
    def tint(self):
        return self._tint

    @tint.setter
    def tint(self, tint):
        self._tint = tint

    def burn(self):
        return "burns"


def test_what_a_class_declares_can_be_set():
    lamp = Lamp()
    lamp.position, lamp.tint, lamp._own = (1, 2, 3), "blue", 1
    lamp.burn = lambda: "is replaced"  # as tests do
    assert (lamp.position, lamp.tint, lamp._own, lamp.burn()) == ((1, 2, 3), "blue", 1, "is replaced")


@pytest.mark.parametrize(
    ("name", "remedy"),
    [
        ("positon", "Did you mean 'position'?"),
        ("colour", "Did you mean 'tint'?"),
        ("color", "It has burn, position, tint."),
        ("size", "It has burn, position, tint."),
    ],
)
def test_anything_else_is_refused_with_the_close_match(name, remedy):
    lamp = Lamp()
    with pytest.raises(AttributeError) as caught:
        setattr(lamp, name, 1)
    assert str(caught.value) == f"Lamp has no attribute {name!r}. {remedy}"
    assert not hasattr(lamp, name)


def test_a_kind_of_ones_own_is_free():
    class Own(Lamp):
        pass

    lamp = Own()
    lamp.size = 3
    assert lamp.size == 3
