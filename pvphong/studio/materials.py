"""The materials of a pane's lit meshes, as something whose edits can be undone."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pvphong.optics.material import Material
from pvphong.studio.live import Finish, LiveMesh

MaterialsState = tuple[tuple[Finish, Material], ...]


class Materials:
    """The materials of some meshes.

    Parameters
    ----------
    meshes : callable
        Gives the meshes there are now.
    """

    def __init__(self, meshes: Callable[[], Sequence[LiveMesh]]) -> None:
        self._meshes = meshes

    @property
    def finishes(self) -> tuple[Finish, ...]:
        """Each material's place, once where meshes share it."""
        return tuple({id(live.finish): live.finish for live in self._meshes()}.values())

    @property
    def state(self) -> MaterialsState:
        """What each of them is."""
        return tuple((finish, finish.material) for finish in self.finishes)

    def turn(self, now: MaterialsState, then: MaterialsState) -> None:
        """Undo what changed from `then` to `now`; what else has changed since is left as it is."""
        was = dict(then)
        for finish, material in now:
            if was.get(finish, material) != material:
                finish.material = was[finish]
