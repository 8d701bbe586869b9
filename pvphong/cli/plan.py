"""`pvphong plan`: which effects a scene calls for."""

from __future__ import annotations

from typing import Any

import pyvista as pv

from pvphong.cli.inputs import SIZE, surface_and_scene
from pvphong.cli.lighting import with_materials
from pvphong.cli.options import (
    NONE,
    PLAIN,
    BlockerOptions,
    FeatureAngleOption,
    LookOptions,
    SceneFile,
    Verbose,
    feature_angle_of,
)
from pvphong.cli.telling import tell
from pvphong.meshes.lit import plan as plan_mesh
from pvphong.meshes.visibility import visibility_options


def plan(
    mesh: str,
    /,
    *,
    scene: SceneFile = None,
    look: LookOptions = PLAIN,
    tolerance: float = 0.0,
    feature_angle: FeatureAngleOption = "auto",
    blockers: BlockerOptions = NONE,
    verbose: Verbose = False,
) -> None:
    """Say which effects a scene calls for on a mesh and which are left out; with --verbose, why.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    tolerance
        Largest absolute colour error that may be traded for time; 1/255 = 0.0039 is one step of a display.
    feature_angle
        Degrees between two faces from which their common edge is sharp; "auto" takes 30 where the mesh has no point
        normals of its own, and "none" leaves all of it smooth.
    """
    outside, lighting = surface_and_scene(mesh, scene, SIZE)
    lighting = blockers.to_scene(lighting)
    materials = look.to_materials(scene)
    options: Any = {"tolerance": tolerance, "feature_angle": feature_angle_of(feature_angle)}
    options["occluders"] = blockers.to_meshes()
    rays = visibility_options(outside, lighting, options) if isinstance(outside, pv.MultiBlock) else iter([options])
    found = (
        (block, plan_mesh(single, lighting, material, **next(rays)))
        for block, single, material in with_materials(outside, materials)
    )
    tell(found, verbose)
