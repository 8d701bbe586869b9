"""Undo and redo: one step for each finished drag or edit."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

_LONGEST = 256


class Editable(Protocol):
    """What edits change: the lights of a subplot, or the materials of its meshes."""

    @property
    def state(self) -> Any:
        """All of it as a value."""

    def revert(self, now: Any, then: Any) -> None:
        """Undo what changed from the state `then` to the state `now`, to the bit."""


@dataclass(frozen=True)
class Step:
    """What was edited, before and after."""

    edited: Editable
    before: Any
    after: Any


class History:
    """The steps that can be undone, and those that can be redone; the last 256 of each."""

    def __init__(self) -> None:
        self._done: deque[Step] = deque(maxlen=_LONGEST)
        self._undone: deque[Step] = deque(maxlen=_LONGEST)

    def record(self, edited: Editable, before: Any) -> None:
        """Remember what has been changed since the state `before`, if anything."""
        after = edited.state
        if after != before:
            self._done.append(Step(edited, before, after))
            self._undone.clear()

    @contextmanager
    def edit(self, edited: Editable) -> Iterator[None]:
        """What is done inside becomes one step."""
        before = edited.state
        yield
        self.record(edited, before)

    def undo(self) -> bool:
        """Take the last step back, to the bit; False if there is none."""
        if not self._done:
            return False
        step = self._done.pop()
        step.edited.revert(step.after, step.before)
        self._undone.append(step)
        return True

    def redo(self) -> bool:
        """Take the last step that was undone again; False if there is none."""
        if not self._undone:
            return False
        step = self._undone.pop()
        step.edited.revert(step.before, step.after)
        self._done.append(step)
        return True

    def clear(self) -> None:
        """Forget all steps."""
        self._done.clear()
        self._undone.clear()
