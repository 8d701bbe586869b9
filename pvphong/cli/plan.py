"""`pvphong plan`: which effects a scene calls for."""

from __future__ import annotations

from pvphong.cli.inputs import NOTHING, SIZE, single_meshes, surface_and_scene
from pvphong.cli.options import PLAIN, LookOptions, Rig
from pvphong.meshes.lit import plan as plan_mesh


def plan(mesh: str, /, *, scene: Rig = None, look: LookOptions = PLAIN, tolerance: float = 0.0) -> None:
    """Say which effects a scene calls for on a mesh, which are left out, and why.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    tolerance
        Largest absolute colour error that may be traded for time; 1/255 = 0.0039 is one step of a display.
    """
    outside, rig = surface_and_scene(mesh, scene, SIZE)
    material = look.to_material()
    plans = [(block, plan_mesh(single, rig, material, tolerance=tolerance)) for block, single in single_meshes(outside)]
    for block, found in plans:
        if block:
            print(f"{block}:")
        print(found.explain())
    if not plans:
        print(NOTHING)
