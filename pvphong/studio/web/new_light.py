"""A new light: its place, and an intensity that brightens the picture without overexposing it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pvphong.base.types import Float64Array, Vector
from pvphong.base.vectors import unit_vector
from pvphong.geometry.transform import transform_points
from pvphong.optics.light import Light
from pvphong.optics.roles import Aim, Corners, Length, Place, Up
from pvphong.scene.scene import Scene
from pvphong.scene.viewer import Viewer
from pvphong.studio.gizmos.gizmo import Gizmos
from pvphong.studio.gizmos.handles import LightInScene
from pvphong.studio.lit_mesh import LitMesh

# scene sizes; and the brightness that it gives to a white surface at the centre.
_PLACE, _LARGE, _BRIGHT = (-0.6, 0.6, 0.5), 0.2, 0.6
_STOPS = 1.0 / 3.0
_HEIGHTS = np.linspace(-1.0, 1.0, 4000)
_ANGLES = math.pi * (3.0 - math.sqrt(5.0)) * np.arange(4000.0)  # the golden angle spaces directions evenly
_ALL_AROUND = np.stack([*(np.sqrt(1.0 - _HEIGHTS**2) * (np.cos(_ANGLES), np.sin(_ANGLES))), _HEIGHTS])
_BRIGHTEST = 0.6
_APART = 0.45  # distance to the right of an existing light, in scene sizes
_DARK = 1.0 / 255.0  # a mean below this is no picture that a light could spoil


def placed_before(light: Light, center: Vector, size: float, viewer: Viewer, *, right: float = 0.0) -> Light:
    """Return a light in front of the scene, in world coordinates, at a suitable intensity.

    It shines from the upper left.

    Parameters
    ----------
    light : Light
        A light with the defaults of its kind.
    center, size
        The scene's centre, and half its diagonal.
    viewer : Viewer
        The viewer, who defines left and up.
    right : float, default 0
        Offset of the light to the right, as a multiple of `size`.
    """
    middle, axes = np.array(center), viewer.axes
    place = middle + size * np.add(_PLACE, (right, 0.0, 0.0)) @ axes
    ahead = np.array(unit_vector((middle - place).tolist()))
    across = np.array(unit_vector(np.cross(axes[1], ahead).tolist()))
    local = np.stack([across, np.cross(across, ahead), -ahead])  # the corners' default normal is −z
    light = light.with_values(Place, place.tolist()).with_values(Aim, (middle - place).tolist())
    light = light.with_values(Length, _LARGE * size).with_values(Up, viewer.up)
    for corners in light.values(Corners):
        light = light.with_values(Corners, (place + 2.0 * _LARGE * size * np.array(corners) @ local).tolist())
    strength = float(np.broadcast_to(light.arrival(middle[:, None]).strength, 1)[0])
    if strength == 0.0:  # it does not shine ahead, as a lamp for ceilings: take its brightest direction
        around = place[:, None] + np.linalg.norm(middle - place) * _ALL_AROUND
        strength = float(np.max(light.arrival(around).strength))
    return replace(light, intensity=_BRIGHT / strength) if 0.0 < strength < math.inf else light


def placed_apart(light: Light, gizmos: Gizmos, viewer: Viewer) -> Light:
    """Return a light placed as by `placed_before`, as far to the right as needed to be apart from all other lights."""
    scenery, taken = gizmos.scenery, [gizmo.in_scene(gizmos.view).origin for gizmo in gizmos.all]
    for column in range(len(taken) + 1):
        placed = placed_before(light, scenery.center, scenery.size, viewer, right=_APART * column)
        origin = LightInScene(placed, scenery).origin
        if all(math.dist(origin, other) > _LARGE * scenery.size for other in taken):
            break
    return placed


def brightened(light: Light, scene: Scene, meshes: Sequence[LitMesh], white: float = 1.0) -> Light:
    """Return a light with an intensity that raises the mean colour of the picture by a third of a stop.

    The mean is that of the surfaces that face the viewer. Shadows of the new light, and clipping, are neglected, so the
    true increase may be smaller. A light adds at most 0.6 of white anywhere, so that a narrow spot is not too bright.
    If the picture is black, or the light reaches nothing, the light is returned unchanged.

    Parameters
    ----------
    light : Light
        The new light, at its place.
    scene : Scene
        The scene without the new light.
    meshes : sequence of LitMesh
        The meshes, with their present colours.
    white : float, default 1
        Colour that the display shows as white.
    """
    if scene.viewer is None:
        return light
    before = added = total = peak = 0.0
    for mesh in meshes:
        triangles = mesh.drawn.triangulate().regular_faces
        weights = _towards(scene.viewer, mesh, triangles)
        share = _share(replace(light, intensity=1.0), scene, mesh)
        before += _sum(mesh.linear.astype(np.float64), triangles, weights)
        added += _sum(share, triangles, weights)
        total += float(weights.sum())
        peak = max(peak, float(share[triangles[weights > 0.0]].max(initial=0.0)))
    if not total or before < _DARK * white * total or not 0.0 < added < np.inf:
        return light
    return replace(light, intensity=min((2.0**_STOPS - 1.0) * before / added, _BRIGHTEST * white / peak))


def _sum(colors: Float64Array, triangles: np.ndarray, weights: Float64Array) -> float:
    """Return the weighted sum over triangles of the mean colour of each triangle.

    `colors` are those of the vertices, shape (n, 3). `triangles` has the vertices of each triangle, shape (m, 3), and
    `weights` its weight, shape (m,).
    """
    return float(weights @ colors.mean(axis=1)[triangles].mean(axis=1))


def _towards(viewer: Viewer, mesh: LitMesh, triangles: np.ndarray) -> Float64Array:
    """Return the area of each triangle as the viewer sees it, shape (m,); 0 for triangles that face away."""
    points = np.asarray(mesh.drawn.points, np.float64)
    if mesh.matrix is not None:
        points = transform_points(points, mesh.matrix)
    p, q, r = (points[triangles[:, corner]] for corner in range(3))
    to_viewer = np.array(viewer.position) - (p + q + r) / 3.0
    to_viewer /= np.maximum(np.linalg.norm(to_viewer, axis=1, keepdims=True), np.finfo(float).tiny)
    return np.maximum(np.einsum("ki,ki->k", np.cross(q - p, r - p), to_viewer) / 2.0, 0.0)


def _share(light: Light, scene: Scene, mesh: LitMesh) -> Float64Array:
    """Return the colours (n, 3) that a light adds to a mesh, without shadows."""
    model = replace(scene.light_model, shadows=False, ambient_occlusion=False, bounces=0, ambient=0.0, clamp=False)
    colors = []
    for intensity in (light.intensity, 0.0):
        alone = Scene([replace(light, intensity=intensity)], scene.viewer, model)
        plan, vertices = mesh.planned(alone)
        colors.append(np.asarray(plan.run(vertices).rgb, np.float64))
    return np.nan_to_num(colors[0] - colors[1])
