"""A lit mesh in a window: its colours, and the changes after which they are recomputed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.util.numpy_support import vtk_to_numpy

from pvphong.base import check
from pvphong.base.display import Display
from pvphong.base.types import ByteArray, Float64Array, FloatArray
from pvphong.meshes.blocks import DEFAULT, datasets, leaves, materials_of, single_material
from pvphong.meshes.colormaps import over_all
from pvphong.meshes.point_data import colors_at, given_maps, opacity_at, tangents_from, texture_version, values_at
from pvphong.meshes.stages import StageOptions
from pvphong.meshes.surfaces import FeatureAngle, has_normals, point_normals, sharp_angle, split_sharp_edges, surface
from pvphong.meshes.visibility import KnownOccluders, visibility_of
from pvphong.optics.colormap import Colormap
from pvphong.optics.maps import AnyMap, Map, is_image_path, is_texture, map_in
from pvphong.optics.material import Material, as_material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, light_labels
from pvphong.shading.plan.plan import Plan
from pvphong.shading.reference import Shading
from pvphong.shading.vertices import Vertices

ARRAY = "phong"
"""Name of the drawn mesh's colours, uint8 RGB."""

TRANSLUCENT_ARRAY = "phong_rgba"
"""Name of the drawn mesh's colours with opacities, uint8 RGBA; present if opacity is per vertex."""


@dataclass(eq=False)
class SharedMaterial:
    """A material that meshes may share. Setting `material` changes all these meshes.

    Parameters
    ----------
    material : Material
        The current material. It can be set at any time.
    """

    material: Material


_PLAIN = Display()


class LitMesh:
    """A surface, its material, and its computed colours.

    The drawn mesh shares points and arrays with the user's mesh. It has its own colours, which are written in place
    while the number of points stays the same. No NumPy view of VTK's memory is kept between frames, because resizing an
    array would leave it invalid.

    Parameters
    ----------
    mesh : pyvista.DataSet
        The user's mesh. It is not modified. If the user edits it, the next frame shows the change.
    material : Material or SharedMaterial
        A material, or a material shared with other meshes. If textures, or arrays that the material names, are edited
        or replaced, the next frame shows the change. Edits of an array that is passed directly are shown only if the
        array belongs to a mesh.
    feature_angle : float, "auto" or None, default None
        An edge is sharp if the normals of its two faces differ by more than this angle, in degrees. "auto" is 30 if the
        mesh has no point normals, and None if it has. With None, no edge is sharp. It can be set at any time.
    opacity : array_like or str, optional
        An opacity for each of the mesh's points or cells, or the name of such an array. The next frame shows edits of
        the named array.
    """

    def __init__(
        self,
        mesh: pv.DataSet,
        material: Material | SharedMaterial,
        *,
        feature_angle: FeatureAngle = None,
        opacity: Any = None,
    ) -> None:
        surface(mesh)  # raises if there is nothing to light
        self.mesh = mesh
        self.feature_angle: FeatureAngle = feature_angle
        self.shared_material = material if isinstance(material, SharedMaterial) else SharedMaterial(material)
        self.casts_shadows = True
        """True if the mesh blocks light for shadows and ambient occlusion. Can be set at any time."""
        self.block = ""
        """Path of the block in its MultiBlock, as materials name it; "" for any other mesh."""
        self.stage: StageOptions | None = None
        """The arguments of `pvphong.stage` from which the mesh was made; None if it is not a stage."""
        self.drawn = pv.PolyData()
        self.actor: pv.Actor | None = None
        self.evaluations = 0
        """Number of times the colours have been computed."""
        self.ray_tolerance = 1.0 / 255.0
        """Standard error of colours up to which rays to lights with a size, and to the sky, are cast."""
        self.bounced: FloatArray | None = None
        """Bounced light in the current colours, shape (1, n, 3)."""
        self._opacity = map_in("opacity", opacity)
        self._colors: Any = None
        self._geometry: Any = None
        self._computed_normals: FloatArray | None = None
        self._tangents: Callable[[], FloatArray] | None = None
        self._textured: dict[str, tuple[Any, Any]] = {}
        self._original_points: Any = None
        self._whole = pv.PolyData()
        self._lit_for: Any = None
        self._eye: Any = None
        self._plan: Plan | None = None
        self._visibility: tuple[Any, Visibility] | None = None
        self._display = Display()
        self._linear: FloatArray | None = None
        self.geometry()
        self._show_colors()

    def __repr__(self) -> str:
        return f"<LitMesh of {self.mesh.n_points} points, {self.material}>"

    @property
    def version(self) -> Any:
        """A value that changes whenever geometry, material, arrays or `ray_tolerance` change; cheap to compare."""
        maps = tuple((name, self._version_of(given)) for name, given in given_maps(self.material, self.mesh).items())
        opacity = None if self._opacity is None else self._version_of(self._opacity)
        return self.material, self.geometry(), maps, opacity, self.ray_tolerance

    @property
    def state(self) -> Any:
        """A value that changes whenever an input of the current colours changes; cheap to compare."""
        return self._lit_for, self._eye if self._plan is not None and self._plan.view_dependent else None

    def planned(
        self, scene: Scene, occluders: KnownOccluders | None = None, samples: int | None = None
    ) -> tuple[Plan, Vertices]:
        """Return the plan that lights the mesh in a scene, and the mesh's vertices as the plan's input.

        A plan is the lighting equation without terms that have no effect here.

        Parameters
        ----------
        scene : Scene
            Lights, viewer and light model.
        occluders : KnownOccluders, optional
            Occluders for shadows and ambient occlusion; by default only the mesh itself.
        samples : int, optional
            Number of rays from each vertex to an area light, or `HARD`; by default as many as accuracy needs.

        Raises
        ------
        ValueError
            If the mesh cannot be lit after an edit of its geometry or arrays.
        """
        visibility = None
        if scene.light_model.needs_rays:
            visibility = self._seen(scene, occluders, samples)
            self.know(visibility, occluders, scene)
        return self._planned(scene, visibility)

    def final_visibility(self, scene: Scene, occluders: KnownOccluders | None) -> tuple[Plan, Visibility]:
        """Return the plan for a scene, that is, its simplified lighting equation, and the visibility that it reads.

        The visibility has as many rays as accuracy needs, but no ray is cast yet. `occluders` are the meshes that cast
        shadows.
        """
        visibility = self._seen(scene, occluders, None)
        return self._planned(scene, visibility)[0], visibility

    def know(self, visibility: Visibility, occluders: KnownOccluders | None, scene: Scene) -> None:
        """Store a visibility, so that its rays are not cast again while meshes and lights stay where they are.

        `occluders` and `scene` are the meshes and the scene for which `visibility` was computed.
        """
        self._visibility = self._visible_in(occluders, scene), visibility

    def _visible_in(self, occluders: KnownOccluders | None, scene: Scene) -> Any:
        """Return a value that changes with everything on which visibility depends, except the lights.

        This is the mesh's own geometry, the geometry of `occluders`, and the light model of the scene.
        """
        model = scene.light_model
        around = occluders and occluders.occluders
        return self.geometry(), around, model.two_sided, model.occlusion_distance, self.ray_tolerance

    def _seen(self, scene: Scene, occluders: KnownOccluders | None, samples: int | None) -> Visibility:
        """Return the visibility in a scene. Known results are reused if they have enough rays.

        `occluders` are the meshes that cast shadows; None if only this mesh does. `samples` is the number of rays from
        each vertex to an area light; None for as many as accuracy needs.
        """
        if self._visibility is not None and self._visibility[0] == self._visible_in(occluders, scene):
            known = self._visibility[1]
        else:
            how: dict[str, Any] = {"occluders": occluders or (), "matrix": self.matrix}
            known = visibility_of(self.drawn, lambda: self.normals, scene, tolerance=self.ray_tolerance, **how)
        return known.for_lights(scene.world_lights, light_labels(scene), samples)

    def _planned(self, scene: Scene, visibility: Visibility | None) -> tuple[Plan, Vertices]:
        vertices = self._vertices(visibility)
        return Plan.of(scene, self.material, vertices, matrix=self.matrix), vertices

    def _vertices(self, visibility: Visibility | None) -> Vertices:
        """Return the drawn vertices with the values of the material's maps."""
        maps = {name: self._values(name, given) for name, given in given_maps(self.material, self.mesh).items()}
        tangents = maps.pop("tangents", self._tangents)
        return Vertices(self.drawn.points, lambda: self.normals, maps, visibility, tangents=tangents)

    def shading_at(self, row: int) -> Shading | None:
        """Return the components of the current colour of a drawn vertex; None before the first refresh.

        They include the contribution of each light. `row` is the index of the vertex.
        """
        if self._plan is None:
            return None
        rows, bounced = np.array([row]), self.bounced
        is_seen = self._plan.equation.needs_visibility and self._visibility is not None
        vertices = self._vertices(self._visibility[1] if is_seen and self._visibility else None).some(rows)
        return self._plan.run(vertices, components=True, bounced=None if bounced is None else bounced[:, rows])

    @property
    def sharp_angle(self) -> float | None:
        """Angle in degrees above which edges are sharp, as last drawn; None if all edges are smooth."""
        return sharp_angle(self._whole, self.feature_angle)

    def refresh(
        self,
        scene: Scene,
        occluders: KnownOccluders | None = None,
        *,
        samples: int | None = None,
        bounced: FloatArray | None = None,
        display: Display = _PLAIN,
    ) -> bool:
        """Update the colours; return True if they had to be recomputed.

        The colours are recomputed only if an input of the plan has changed. The viewer is an input only if highlights,
        flipped normals or a light attached to the viewer depend on it. Rays are traced again only for lights that have
        moved, or if `ray_tolerance` has changed.

        Parameters
        ----------
        scene : Scene
            Lights, viewer and light model.
        occluders : KnownOccluders, optional
            Occluders for shadows and ambient occlusion; by default only the mesh itself.
        samples : int, optional
            Number of rays from each vertex to an area light, or `HARD`; by default as many as accuracy needs.
        bounced : ndarray, optional
            Bounced light, shape (1, n, 3). A change is detected by identity, so pass a new array instead of editing the
            last one.
        display : Display, optional
            Transform that shows the colours. For a display other than the default, the light model does not clamp. So a
            lower exposure shows details that were too bright. If one such display replaces another, the mesh is not lit
            again.

        Raises
        ------
        ValueError
            If the mesh cannot be lit after an edit of its geometry or arrays. Geometry that would crash VTK is not
            drawn until it is corrected.
        """
        if display != _PLAIN:
            scene = replace(scene, light_model=replace(scene.light_model, clamp=False))
        version, blockers = self.version, occluders and occluders.occluders
        self._show_colors()
        arriving = None if bounced is None else Map(bounced)  # compared by its identity
        state = scene.lights, scene.light_model, version, blockers, samples, arriving
        viewer = scene.viewer
        eye = viewer and (viewer.position, viewer.focal_point, viewer.up, viewer.parallel)
        is_lit = state == self._lit_for and self._plan and (eye == self._eye or not self._plan.view_dependent)
        if is_lit and display == self._display:
            return False
        self._display = display
        if not is_lit or self._linear is None:
            self._plan, vertices = self.planned(scene, occluders, samples)
            if self._plan.equation.bounces and bounced is None:
                self._plan.sent(vertices)  # raises with the reason
                bounced = np.zeros((1, len(vertices), 3), np.float32)
            if display == _PLAIN:
                self._plan.run_for_display(vertices, vtk_to_numpy(self._colors), bounced)
                self._linear = None
            else:
                self._linear = self._plan.run(vertices, bounced=bounced).rgb
            self._lit_for, self._eye, self.bounced = state, eye, bounced
            self.evaluations += 1
        self.write_colors()
        return True

    def write_colors(self) -> bool:
        """Write the colours, after the display transform, to the array that VTK draws, and return True.

        With the default display, no linear colours are kept. Then nothing is written, and the result is False.
        """
        if self._linear is not None:
            self._display(self._linear, vtk_to_numpy(self._colors))
        self.show_colors()
        return self._linear is not None

    def show_colors(self) -> None:
        """Mark the colours as modified, so that the next frame draws them."""
        self._colors.Modified()
        if (opacities := self.opacities()) is not None:
            rgba = np.column_stack([vtk_to_numpy(self._colors), opacities])
            self.drawn.point_data[TRANSLUCENT_ARRAY] = rgba
            self.drawn.set_active_scalars(TRANSLUCENT_ARRAY, preference="point")

    def opacities(self) -> ByteArray | None:
        """Return an opacity for each drawn vertex, uint8; None if the whole actor has a single opacity."""
        if self._opacity is None:
            return None
        found = opacity_at(self._opacity, self.mesh, self._whole, self.drawn, self._original_points)
        return np.rint(255.0 * found).astype(np.uint8)

    @property
    def shown_array(self) -> str:
        """Name of the array with the colours that VTK shows, in the drawn mesh."""
        return ARRAY if self._opacity is None else TRANSLUCENT_ARRAY

    @property
    def linear(self) -> FloatArray:
        """Current linear colours of the drawn mesh, shape (n, 3).

        With the default display, they are rounded to 8 bits.
        """
        drawn = vtk_to_numpy(self._colors) / np.float32(255.0)
        return drawn if self._linear is None else self._linear.astype(np.float32)

    def as_shown(self) -> pv.PolyData:
        """Return a copy of the mesh as the window shows it, with linear colours as float32.

        With the default display, this is a refined mesh if the window shows one. With any other display, it is the
        mesh's own surface.
        """
        if self._linear is not None:
            copied = self.drawn.copy()
            copied.point_data[ARRAY] = self.linear
            copied.set_active_scalars(ARRAY, preference="point")
            return copied
        shown = self.drawn if self.actor is None else self.actor.mapper.dataset
        if shown.n_points < self.drawn.n_points:  # a coarse stand-in; a refined mesh begins with the mesh's own points
            shown = self.drawn
        copied = shown.copy()
        copied.point_data[ARRAY] = np.asarray(copied.point_data[ARRAY])[:, :3].astype(np.float32) / np.float32(255.0)
        copied.set_active_scalars(ARRAY, preference="point")
        return copied

    def blank(self) -> None:
        """Draw an empty mesh until the next successful refresh. VTK would crash on a vertex index out of range."""
        self.drawn.Initialize()
        self._geometry = self._lit_for = None

    @property
    def material(self) -> Material:
        """The surface's material. Setting it affects all meshes that share it."""
        return self.shared_material.material

    @material.setter
    def material(self, material: Material) -> None:
        self.shared_material.material = as_material(material)

    @property
    def matrix(self) -> Float64Array | None:
        """The actor's model matrix, (4, 4); None if it is the identity."""
        if self.actor is None:
            return None
        values = np.array(self.actor.GetMatrix().GetData()).reshape(4, 4)
        return None if np.array_equal(values, np.eye(4)) else values

    @property
    def normals(self) -> FloatArray:
        """The point normals used for shading."""
        if has_normals(self.drawn):
            return point_normals(self.drawn)
        if self._computed_normals is None:
            self._computed_normals = point_normals(self.drawn)
        return self._computed_normals

    def geometry(self) -> Any:
        """Update the drawn mesh if the user's points, faces or arrays have been replaced or edited.

        Returns
        -------
        object
            A stamp that changes with points, faces, normals and matrix; cheap to compare.

        Raises
        ------
        ValueError
            If the mesh cannot be lit after an edit.
        """
        mesh, matrix = self.mesh, self.matrix
        place = None if matrix is None else matrix.tobytes()
        if isinstance(mesh, pv.PolyData):
            data = mesh.GetPointData()
            parts = (mesh.GetPoints(), mesh.GetPolys(), mesh.GetStrips(), data.GetNormals(), data.GetTCoords())
            # The number of points is included because resizing an array in place need not change its modification time.
            geometry: Any = self.feature_angle, mesh.GetNumberOfPoints(), *map(_version, parts)
        else:
            geometry = self.feature_angle, mesh.GetMTime()
        if geometry == self._geometry:
            return geometry, place
        try:
            whole = surface(mesh)
        except ValueError:
            self.blank()  # VTK would still draw the mesh, and may crash
            raise
        split, self._original_points = split_sharp_edges(whole, self.feature_angle)
        self._whole = whole
        self.drawn.ShallowCopy(split)
        self._geometry, self._computed_normals, self._textured = geometry, None, {}
        tangents = tangents_from(self.drawn, lambda: self.normals)
        self._tangents = tangents and cache(tangents)
        return geometry, place

    def _show_colors(self) -> None:
        """Make the array of colours the active scalars of the drawn mesh.

        If the number of points has changed, make a new array.
        """
        data, count = self.drawn.GetPointData(), self.drawn.n_points
        if self._colors is None or self._colors.GetNumberOfValues() != 3 * count:
            self._colors, self._lit_for = pv.convert_array(np.zeros((count, 3), np.uint8), ARRAY), None
        if data.GetAbstractArray(ARRAY) is not self._colors:
            data.AddArray(self._colors)
            self.drawn.set_active_scalars(ARRAY, preference="point")

    def _version_of(self, given: AnyMap) -> Any:
        if isinstance(given, Colormap):
            scalars, table = given.scalars, getattr(given.cmap, "GetMTime", None)
            if not isinstance(scalars, str):
                return given, _version(getattr(scalars, "VTKObject", None)), table and table()
            data = (self.mesh.GetPointData(), self.mesh.GetCellData())
            return given, table and table(), *(_version(each.GetAbstractArray(scalars)) for each in data)
        if isinstance(given, str):  # an array of the user's mesh, which may be replaced
            mesh = self.mesh if isinstance(self.mesh, pv.PolyData) else self.drawn
            data = (mesh.GetPointData(), mesh.GetCellData())
            return given, *(_version(each.GetAbstractArray(given)) for each in data)
        source = given.source
        return texture_version(source) if is_texture(source) else (given, _version(getattr(source, "VTKObject", None)))

    def _values(self, name: str, given: AnyMap) -> Any:
        """Return the values of a map at the drawn points.

        `given` is the value of the material's field `name`: an array, the name of an array, a texture or a colormap.
        Textures and colormaps are sampled again only if they have changed.
        """
        if isinstance(given, str) and isinstance(self.mesh, pv.PolyData):  # the drawn mesh may have an older array
            if given in self.mesh.point_data:
                given = Map(self.mesh.point_data[given])
            elif given in self.mesh.cell_data and self.mesh.n_cells == self.drawn.n_cells:
                self.drawn.cell_data[given] = self.mesh.cell_data[given]
        version = self._version_of(given)
        if name in self._textured and self._textured[name][0] == version:
            return self._textured[name][1]
        if isinstance(given, Colormap):
            found = colors_at(name, given, self.mesh, self._whole, self.drawn, self._original_points)
            self._textured[name] = version, found
            return found
        values = values_at(name, given, self._whole, self.drawn, self._original_points)
        if is_image_path(given) or (isinstance(given, Map) and is_texture(given.source)):
            self._textured[name] = version, np.array(values, np.float32)
        return values


def _version(part: Any) -> Any:
    """Return a value that changes when the VTK object `part` is modified; None for None.

    The value holds a reference, so that no new object gets the same address. The object is wrapped in a `Map`, which
    compares by identity, because VTK arrays compare by value.
    """
    return None if part is None else (Map(part), part.GetMTime())


def lit_meshes(
    mesh: Any,
    material: Material | str | Mapping[str, Material | str],
    feature_angle: FeatureAngle,
    opacity: Any = None,
) -> dict[str, LitMesh]:
    """Return a lit mesh for each block, as path → lit mesh. A mesh without blocks has the path "".

    If a single material is given, all blocks share it.

    Parameters
    ----------
    mesh : pyvista.DataSet or pyvista.MultiBlock
        The mesh or the blocks.
    material : Material, str or mapping
        A material, or a mapping from paths of blocks to materials.
    feature_angle : float, "auto" or None
        Angle in degrees between the normals of two faces, above which their edge is sharp; see `LitMesh`.
    opacity : array_like or str, optional
        An opacity for each of the mesh's points or cells, or the name of such an array.

    Raises
    ------
    ValueError
        If there is nothing to light, or a material is invalid; the message names the block.
    """
    given = material if isinstance(material, Mapping) else {DEFAULT: material}
    materials = {name: as_material(each) for name, each in given.items()}
    if not isinstance(mesh, pv.MultiBlock):
        return {"": LitMesh(mesh, single_material(materials), feature_angle=feature_angle, opacity=opacity)}
    shared = {name: SharedMaterial(over_all(each, leaves(mesh))) for name, each in materials.items()}
    found, blocks = {}, list(datasets(mesh))
    for (path, block), own in zip(blocks, materials_of([path for path, _ in blocks], shared), strict=True):
        try:
            found[path] = LitMesh(block, own, feature_angle=feature_angle, opacity=opacity)
        except ValueError as error:
            raise ValueError(f"block {path!r}: {error}") from error
        found[path].block = path
    if not found:
        check.refuse("mesh", "a MultiBlock without a mesh", "a MultiBlock that contains a mesh")
    return found
