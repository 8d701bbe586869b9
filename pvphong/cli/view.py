"""`pvphong view`: a lit mesh in a window."""

from __future__ import annotations

from pathlib import Path

from pvphong.cli.inputs import SIZE, seeing, surface_and_scene
from pvphong.cli.options import (
    NONE,
    PLAIN,
    BlockerOptions,
    FeatureAngleOption,
    LookOptions,
    SceneFile,
    albedo_of,
    feature_angle_of,
)
from pvphong.cli.window import BACKGROUND, show


def view(
    mesh: str,
    /,
    *,
    scene: SceneFile = None,
    look: LookOptions = PLAIN,
    albedo: str | None = None,
    feature_angle: FeatureAngleOption = "auto",
    blockers: BlockerOptions = NONE,
    background: str = BACKGROUND,
) -> None:
    """Show a lit mesh in a window, with gizmos to place its lights; the key h lists the keys.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    albedo
        Colours that multiply the material's ambient and diffuse: the name of a point array, or an image file that is
        laid on by the mesh's texture coordinates.
    feature_angle
        Degrees between two faces from which their common edge is sharp; "auto" takes 30 where the mesh has no point
        normals of its own, and "none" leaves all of it smooth.
    background
        Colour of the window's background.
    """
    outside, lighting = surface_and_scene(mesh, scene, SIZE)
    lighting = blockers.to_scene(lighting)
    show(
        outside,
        seeing(lighting, outside, SIZE),
        look.to_materials(scene),
        title=f"pvphong: {mesh}",
        stem=Path(mesh).stem,
        background=background,
        albedo=albedo_of(albedo),
        feature_angle=feature_angle_of(feature_angle),
        occluders=blockers.to_meshes(),
    )
