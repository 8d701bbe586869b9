"""`pvphong view`: a lit mesh in a window."""

from __future__ import annotations

from pathlib import Path

from pvphong.cli.inputs import SIZE, surface_and_scene
from pvphong.cli.options import PLAIN, LookOptions, Rig
from pvphong.cli.window import show


def view(mesh: str, /, *, scene: Rig = None, look: LookOptions = PLAIN) -> None:
    """Show a lit mesh in a window, with gizmos to place its lights; the key h lists the keys.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    """
    outside, rig = surface_and_scene(mesh, scene, SIZE)
    show(outside, rig, look.to_materials(scene), title=f"pvphong: {mesh}", stem=Path(mesh).stem)
