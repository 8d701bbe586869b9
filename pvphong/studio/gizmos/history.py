"""Undo and redo: one step for each finished drag or edit."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from pvphong.studio.rig import Rig, RigState

_LONGEST = 256


@dataclass(frozen=True)
class Step:
    """The lights of a rig before and after an edit."""

    rig: Rig
    before: RigState
    after: RigState


class History:
    """The steps that can be undone, and those that can be redone; the last 256 of each."""

    def __init__(self) -> None:
        self._done: deque[Step] = deque(maxlen=_LONGEST)
        self._undone: deque[Step] = deque(maxlen=_LONGEST)

    def record(self, rig: Rig, before: RigState) -> None:
        """Remember what has been changed in a rig since `before`, if anything."""
        after = rig.state
        if after != before:
            self._done.append(Step(rig, before, after))
            self._undone.clear()

    @contextmanager
    def edit(self, rig: Rig) -> Iterator[None]:
        """What is done to a rig inside becomes one step."""
        before = rig.state
        yield
        self.record(rig, before)

    def undo(self) -> bool:
        """Take the last step back, to the bit; False if there is none."""
        if not self._done:
            return False
        step = self._done.pop()
        step.rig.turn(step.after, step.before)
        self._undone.append(step)
        return True

    def redo(self) -> bool:
        """Take the last step that was undone again; False if there is none."""
        if not self._undone:
            return False
        step = self._undone.pop()
        step.rig.turn(step.before, step.after)
        self._done.append(step)
        return True

    def clear(self) -> None:
        """Forget all steps."""
        self._done.clear()
        self._undone.clear()
