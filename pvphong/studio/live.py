"""A mesh in a window whose colours are kept current."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base import check
from pvphong.base.types import ByteArray, Float64Array, FloatArray
from pvphong.meshes.lit import point_normals
from pvphong.meshes.point_data import is_texture, tangents_from, texture_colors, texture_version, values_at
from pvphong.meshes.surfaces import FeatureAngle, has_normals, split_sharp_edges, surface
from pvphong.meshes.visibility import KnownOccluders, visibility_of
from pvphong.optics.material import Material, check_material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, light_labels
from pvphong.scene.viewer import Viewer
from pvphong.shading.plan.plan import Plan
from pvphong.shading.vertices import Vertices

ARRAY = "phong"
"""Name of the drawn mesh's colours, uint8 RGB."""


class Finish:
    """A material's place, which meshes may share.

    Parameters
    ----------
    material : Material
        Can be set at any time.
    """

    def __init__(self, material: Material) -> None:
        self.material = material


class LiveMesh:
    """A surface, its material, and the colours in which it is drawn.

    The mesh that is drawn shares points and arrays with the user's mesh and has its own colours, which are
    written in place for as long as the number of points stays the same. No view of VTK's memory is kept from one
    frame to the next: it would dangle where an array is resized.

    Parameters
    ----------
    mesh : pyvista.DataSet
        The user's mesh; edits to it are followed, and it is not modified.
    material : Material or Finish
        A material of its own, or one that is shared with others.
    albedo : str, array_like, texture or None
        As for `shade`; can be set at any time. A named array or a texture is followed when it is edited or replaced; of
        an array that is given, edits are not seen.
    feature_angle : float, "auto" or None, default None
        Degrees from which edges are sharp, as for `shade`.
    casts_shadows : bool, default True
        Whether it is in the way of light, where the light model has shadows or ambient occlusion.
    """

    def __init__(
        self,
        mesh: pv.DataSet,
        material: Material | Finish,
        albedo: Any = None,
        *,
        feature_angle: FeatureAngle = None,
        casts_shadows: bool = True,
    ) -> None:
        surface(mesh)  # refuses what has nothing that can be lit
        self.mesh = mesh
        self.feature_angle: FeatureAngle = feature_angle
        self.finish = material if isinstance(material, Finish) else Finish(material)
        self.albedo = albedo
        self.casts_shadows = casts_shadows
        self.drawn = pv.PolyData()
        self.actor: pv.Actor | None = None
        self._colors: Any = None
        self._geometry: Any = None
        self._computed_normals: FloatArray | None = None
        self._tangents: Callable[[], FloatArray] | None = None
        self._textured: tuple[Any, FloatArray] | None = None
        self._points: Any = None
        self._n_whole = 0
        self._drawn_for: Any = None
        self._plan: Plan | None = None
        self._seen: tuple[Any, Visibility] | None = None
        self._viewer = Viewer()
        self._follow_geometry()
        self._show_colors()

    def __repr__(self) -> str:
        return f"<LiveMesh of {self.mesh.n_points} points, {self.material}>"

    def refresh(self, scene: Scene, among: KnownOccluders | None = None, *, samples: int | None = None) -> bool:
        """Bring the colours up to date; returns whether they had to be computed.

        They are computed only when something that the plan depends on has changed: the viewer counts only
        where highlights, turned normals or a light that rides along make the colours depend on it. Only lights that
        have moved are traced again.

        Parameters
        ----------
        scene : Scene
            What lights it.
        among : KnownOccluders, optional
            What casts shadows on it, where the light model has shadows or ambient occlusion; by itself if not given.
        samples : int, optional
            So many rays for each vertex to a light with a size, in place of as many as it takes.

        Raises
        ------
        ValueError
            If the mesh or an array has been edited into what cannot be lit. What would crash VTK is not drawn any more,
            until it is put right.
        """
        self._follow_geometry()
        self._show_colors()
        state = *self._state(scene), among and _Same(among.occluders), samples
        if state == self._drawn_for and not self._viewer_moved(scene):
            return False
        screen = self._screen(scene, among, samples) if scene.light_model.needs_rays else None
        arrays = self.drawn.points, lambda: self.normals, self._current_albedo(), screen
        vertices = Vertices(*arrays, tangents=self._tangents)
        self._plan = Plan.of(scene, self.material, vertices, matrix=self.matrix)
        self._plan.run_for_display(vertices, self.colors)
        self._drawn_for, self._viewer = state, scene.viewer
        self._colors.Modified()
        return True

    def blank(self) -> None:
        """Draw nothing, until it can be refreshed again: an index that no point has would end the process."""
        self.drawn.Initialize()
        self._geometry = self._drawn_for = None

    @property
    def material(self) -> Material:
        """The surface's material; setting it sets that of all meshes that share it."""
        return self.finish.material

    @material.setter
    def material(self, material: Material) -> None:
        check_material(material)
        self.finish.material = material

    def _screen(self, scene: Scene, among: KnownOccluders | None, samples: int | None) -> Visibility:
        """What the vertices see, with what is known of lights that stayed where they were."""
        model = scene.light_model
        key = self.shape(), among and _Same(among.occluders), model.two_sided, model.occlusion_distance
        if self._seen is not None and self._seen[0] == key:
            made = self._seen[1].for_lights(scene.world_lights, light_labels(scene), samples)
        else:
            made = visibility_of(
                self.drawn, lambda: self.normals, scene, occluders=among or (), samples=samples, matrix=self.matrix
            )
        self._seen = key, made
        return made

    def shape(self) -> Any:
        """What tells points, faces, normals and place apart from all before, cheap to compare."""
        self._follow_geometry()
        matrix = self.matrix
        return self._geometry, None if matrix is None else matrix.tobytes()

    @property
    def matrix(self) -> Float64Array | None:
        """The actor's model matrix, (4, 4); None where it is the identity."""
        if self.actor is None:
            return None
        values = np.array(self.actor.GetMatrix().GetData()).reshape(4, 4)
        return None if np.array_equal(values, np.eye(4)) else values

    @property
    def normals(self) -> FloatArray:
        """The point normals that it is lit with."""
        if has_normals(self.drawn):
            return point_normals(self.drawn)
        if self._computed_normals is None:
            self._computed_normals = point_normals(self.drawn)
        return self._computed_normals

    @property
    def colors(self) -> ByteArray:
        """The colours that are drawn, (n_points, 3), where they are now."""
        return vtk_to_numpy(self._colors)

    def _viewer_moved(self, scene: Scene) -> bool:
        if self._plan is None or not self._plan.view_dependent:
            return False
        old, new = self._viewer, scene.viewer
        return (old.position, old.focal_point, old.up, old.parallel) != (
            new.position,
            new.focal_point,
            new.up,
            new.parallel,
        )

    def _state(self, scene: Scene) -> Any:
        """Everything but the viewer that the colours depend on, cheap to compare."""
        matrix = self.matrix
        arrays = self._arrays()
        named = arrays.GetAbstractArray(self.albedo) if isinstance(self.albedo, str) else self.albedo
        return (
            scene.lights,
            scene.light_model,
            self.material,
            None if matrix is None else matrix.tobytes(),
            self._geometry,
            self.albedo if isinstance(self.albedo, str) else None,
            self._edition_of(named),
        )

    @staticmethod
    def _edition_of(albedo: Any) -> Any:
        if is_texture(albedo):
            return texture_version(albedo)
        return _edition(albedo) if hasattr(albedo, "GetMTime") else _Same(albedo)

    def _follow_geometry(self) -> None:
        """Share the user's points, faces and arrays again where they have been replaced or edited."""
        geometry = _geometry_of(self.mesh)
        if geometry == self._geometry:
            return
        try:
            whole = surface(self.mesh)
        except ValueError:
            self.drawn.Initialize()  # VTK goes on to draw it, and might not survive that
            self._geometry = None
            raise
        outer, self._points = split_sharp_edges(whole, self.feature_angle)
        self._n_whole = whole.n_points
        self.drawn.ShallowCopy(outer)
        self._geometry, self._computed_normals, self._textured = geometry, None, None
        self._tangents = tangents_from(self.drawn, lambda: self.normals)
        if self._tangents is not None:
            self._tangents = cache(self._tangents)

    def _show_colors(self) -> None:
        """Have the drawn mesh show its colours; new ones where they are not as many as the points."""
        data, count = self.drawn.GetPointData(), self.drawn.n_points
        if self._colors is None or self._colors.GetNumberOfValues() != 3 * count:
            self._colors, self._drawn_for = pv.convert_array(np.zeros((count, 3), np.uint8), ARRAY), None
        if data.GetAbstractArray(ARRAY) is not self._colors:
            data.AddArray(self._colors)
            self.drawn.set_active_scalars(ARRAY, preference="point")

    def _current_albedo(self) -> Any:
        """At the points that are drawn: edges of the user's mesh may have been split."""
        albedo = self.albedo
        if is_texture(albedo):
            edition = texture_version(albedo)
            if self._textured is None or self._textured[0] != edition:
                self._textured = edition, texture_colors(albedo, self.drawn).astype(np.float32)
            return self._textured[1]
        if isinstance(albedo, str):
            arrays = self._arrays()
            check.choice("albedo", albedo, arrays.keys())
            albedo = arrays[albedo]
            if not isinstance(self.mesh, pv.PolyData):
                return albedo
        return values_at("albedo", albedo, self._points, self._n_whole)

    def _arrays(self) -> Any:
        """Where a named albedo is looked up: the user's point arrays, which may be replaced at any time."""
        return (self.mesh if isinstance(self.mesh, pv.PolyData) else self.drawn).point_data


class _Same:
    """Equal to another only if it holds the same object, which it keeps alive: arrays compare element by element."""

    def __init__(self, held: Any) -> None:
        self._held = held

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other._held is self._held

    def __hash__(self) -> int:
        return id(self._held)


def _geometry_of(mesh: pv.DataSet) -> Any:
    """What identifies a mesh's points, faces, normals and texture coordinates, and their last edit."""
    if not isinstance(mesh, pv.PolyData):
        return mesh.GetMTime()
    data = mesh.GetPointData()
    parts = (mesh.GetPoints(), mesh.GetPolys(), mesh.GetStrips(), data.GetNormals(), data.GetTCoords())
    editions = (None if part is None else _edition(part) for part in parts)
    return mesh.GetNumberOfPoints(), *editions  # what resizes an array in place need not say that it is modified


def _edition(part: Any) -> Any:
    """A VTK object and when it was last modified. It is held on to, so that no other can be taken for it."""
    return part, part.GetMTime()
