"""Undo and redo: one step for each finished drag or edit.

Steps of a user do not overlap: before anything else is edited, begun, undone or redone, what runs becomes a step. A
script that edits lights leaves a drag alone.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol


class Editable(Protocol):
    """What edits change: the lights of a subplot, the materials of its meshes, or all that a studio shows."""

    @property
    def state(self) -> Any:
        """What it is now, to be compared, and for `revert`."""

    def revert(self, now: Any, then: Any) -> None:
        """Undo what changed from the state `then` to the state `now`."""


class Running(Protocol):
    """What changes something until it ends, and is one step then: a drag, what is typed, a slider that moves."""

    def settle(self) -> None:
        """End as a step, and say so to `History.end`."""


_LONGEST = 256
_Steps = deque[tuple[Editable, Any, Any]]


class History:
    """The steps that can be undone, and those that can be redone; the last 256 of each."""

    def __init__(self) -> None:
        self._done, self._undone = _Steps(maxlen=_LONGEST), _Steps(maxlen=_LONGEST)
        self.running: Running | None = None
        """What has begun and not ended."""

    def begin(self, running: Running) -> None:
        """Something runs from now on; `settle` comes before it keeps what there was before."""
        self.running = running

    def end(self, running: Running) -> None:
        """Something does not run any more."""
        if self.running is running:
            self.running = None

    def settle(self) -> None:
        """Whatever runs becomes a step."""
        if self.running is not None:
            self.running.settle()

    def record(self, edited: Editable, before: Any) -> None:
        """Remember what has been changed since the state `before`, if anything."""
        after = edited.state
        if after != before:
            self._done.append((edited, before, after))
            self._undone.clear()

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to take back."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """Whether there is a step that was undone."""
        return bool(self._undone)

    @contextmanager
    def edit(self, edited: Editable) -> Iterator[None]:
        """What is done inside becomes one step."""
        before = edited.state
        yield
        self.record(edited, before)

    def undo(self) -> bool:
        """Take the last step back, to the bit; False if there is none."""
        return self._turn(self._done, self._undone)

    def redo(self) -> bool:
        """Take the last step that was undone again; False if there is none."""
        return self._turn(self._undone, self._done)

    def _turn(self, steps: _Steps, turned: _Steps) -> bool:
        """Revert the last of some steps; turned around it is one of the others."""
        self.settle()
        if not steps:
            return False
        edited, then, now = steps.pop()
        edited.revert(now, then)
        turned.append((edited, now, then))
        return True

    def clear(self) -> None:
        """Forget all steps."""
        self._done.clear()
        self._undone.clear()
