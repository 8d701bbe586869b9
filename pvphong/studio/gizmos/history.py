"""Undo and redo: one step for each finished drag or edit.

Steps of the user do not overlap: before another edit, undo or redo, a running edit is ended and recorded. A script that
edits lights does not end a running drag.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Protocol


class Editable(Protocol):
    """An object whose edits can be undone: a subplot's lights, the materials of its meshes, or a studio's document."""

    @property
    def state(self) -> Any:
        """The current state, which `revert` reads. States can be compared by ==."""

    def revert(self, now: Any, then: Any) -> None:
        """Restore the values of the state `then` that differ in the state `now`, and keep all other changes.

        Both arguments are values of `state`.
        """


class Running(Protocol):
    """A continuous edit that becomes one step when it ends: a drag, typing, or a moving slider."""

    def settle(self) -> None:
        """End the edit as one step and call `History.end`."""


_LONGEST = 256
_Steps = deque[tuple[Editable, Any, Any]]


class History:
    """The steps that can be undone, and the undone steps that can be redone; at most 256 of each."""

    def __init__(self) -> None:
        self._done, self._undone = _Steps(maxlen=_LONGEST), _Steps(maxlen=_LONGEST)
        self.running: Running | None = None
        """The continuous edit in progress, or None."""

    def begin(self, running: Running) -> None:
        """Register a continuous edit. The caller must call `settle` before it saves the edit's initial state."""
        self.running = running

    def end(self, running: Running) -> None:
        """Unregister a continuous edit that has ended."""
        if self.running is running:
            self.running = None

    def settle(self) -> None:
        """If a continuous edit is in progress, end it as one step."""
        if self.running is not None:
            self.running.settle()

    def record(self, edited: Editable, before: Any) -> None:
        """Record the changes of `edited` since its state `before` as one step; nothing if it has not changed."""
        after = edited.state
        if after != before:
            self._done.append((edited, before, after))
            self._undone.clear()

    @property
    def can_undo(self) -> bool:
        """True if there is a step to undo."""
        return bool(self._done)

    @property
    def can_redo(self) -> bool:
        """True if there is a step to redo."""
        return bool(self._undone)

    @contextmanager
    def edit(self, edited: Editable) -> Iterator[None]:
        """Return a context. All changes of `edited` inside the context become one step."""
        before = edited.state
        yield
        self.record(edited, before)

    def undo(self) -> bool:
        """Undo the last step exactly; return False if there is none."""
        return self._turn(self._done, self._undone)

    def redo(self) -> bool:
        """Redo the last undone step; return False if there is none."""
        return self._turn(self._undone, self._done)

    def _turn(self, steps: _Steps, turned: _Steps) -> bool:
        """Take the last step from `steps`, revert it, and append the opposite step to `turned`.

        Return False if `steps` is empty.
        """
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
