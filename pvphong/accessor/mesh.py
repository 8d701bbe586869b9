"""`mesh.phong`: lighting on every PyVista dataset with a surface."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import pyvista as pv

from pvphong.accessor.drawing import draw_colors, refuse_unlit
from pvphong.base.types import Backend, FloatArray, MatrixLike, Precision, Weighting
from pvphong.geometry.transform import transform_normals
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import plan, point_normals, shade_mesh
from pvphong.meshes.pictures import ColorSpace, color_view
from pvphong.meshes.surfaces import FeatureAngle, split_sharp_edges, surface
from pvphong.meshes.visibility import visibility_of
from pvphong.optics.material import Material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import SceneLike
from pvphong.shading.plan.plan import Plan

if TYPE_CHECKING:
    from pvphong.studies.accuracy import Tradeoff
    from pvphong.studies.diagnose.diagnosis import Diagnosis
    from pvphong.studies.refine.refinement import Placement
    from pvphong.studies.validate.comparison import Comparison

_DULL = Material()


@pv.register_dataset_accessor("phong", pv.DataSet)
class MeshPhong:
    """Lighting of one dataset; results are new datasets and arrays, the dataset is never modified."""

    def __init__(self, mesh: pv.DataSet) -> None:
        self._mesh = mesh

    def __repr__(self) -> str:
        mesh = self._mesh
        return f"<phong of a {type(mesh).__name__}: {mesh.n_points} points, {mesh.n_cells} cells>"

    def shade(
        self,
        scene: SceneLike | None = None,
        material: Material = _DULL,
        *,
        name: str = "phong",
        matrix: MatrixLike | None = None,
        albedo: Any = None,
        specular: Any = None,
        shininess: Any = None,
        roughness: Any = None,
        tangents: Any = None,
        components: bool = False,
        tolerance: float = 0.0,
        precision: Precision = "float32",
        backend: Backend = "auto",
        feature_angle: FeatureAngle = None,
        occluders: Any = (),
        visibility: Visibility | None = None,
    ) -> pv.PolyData:
        """A new mesh with its lit colours as a point array.

        The mesh's active point normals are used as they are; if it has none they are computed from its
        faces, weighted by angle. A dataset that is not a PolyData gives its extracted surface, with its
        arrays carried along.

        Parameters
        ----------
        scene : Scene, light, or sequence of lights, optional
            Lights, viewer and light model, in world coordinates; the scene of `pvphong.default_scene` if not given.
            Without a viewer, it is seen as PyVista's camera frames the mesh.
        material : Material, optional
            The surface's reflectances; OpenGL's default material if not given.
        name : str, default "phong"
            Name of the array, shape (n_points, 3), linear RGB in [0, 1]; it becomes the active scalars.
        matrix : array_like, optional
            (4, 4) model matrix, as on an actor. It takes part in the lighting; the points stay as they are.
        albedo : array_like, str or pyvista.Texture, optional
            (n_points, 3) colours, or the name of a point array, that multiply the material's ambient and
            diffuse. uint8 counts as 0-255; floats are clipped to [0, 1], a NaN counts as 0. Of a texture, the colours
            at the mesh's texture coordinates: bilinear, with its `wrap`, and as linear light where it says that they
            are sRGB; see `pvphong.meshes.point_data.texture_colors`.
        specular, shininess, roughness : array_like or str, optional
            (n_points,) numbers, of specular (n_points, 3) colours too, or the name of a point array, in place of the
            material's or its reflectance's, which are the same at all points; see `pvphong.evaluate`.
        tangents : array_like or str, optional
            (n_points, 3) vectors along the surface, or the name of a point array, for reflectances that are not the
            same in all directions; from the mesh's texture coordinates, where u grows, if not given.
        components : bool, default False
            Adds `<name>_ambient`, `<name>_diffuse`, `<name>_specular`, `<name>_emission`, which add up to
            the unclamped colour, `<name>_base` (emission and the light model's ambient) and one
            `<name>_light_<name or index>` per light, which together add up to it too.
        tolerance : float, default 0
            Largest absolute colour error that may be traded for time; 0 allows no approximation.
        precision : {"float32", "float64"}
            Of the arrays and the arithmetic. float32 errs by at most (4√n + 16) · 2⁻²⁴ · (1 + number of lights) for
            colours of size 1, n the largest of the shininess and the spot lights' exponents; see `pvphong.evaluate`.
        backend : {"auto", "numpy", "numba"}
            Which evaluator computes, see `pvphong.evaluate`; and normals, see `pvphong.vertex_normals`.
        feature_angle : float, "auto" or None, default None
            Degrees between two faces from which their common edge is sharp: points are duplicated along it, and
            `pvphong_original_point` says which each one was. 0 is flat shading; "auto" takes 30 where the mesh has no
            point normals of its own. None splits nothing.
        occluders : sequence, optional
            Meshes, or pairs of a mesh and a 4x4 matrix, that shadow this one, where the scene's light model has shadows
            or ambient occlusion; it always shadows itself.
        visibility : Visibility, optional
            What `visibility` gave for this mesh and these lights, in place of new rays; or its numbers, as for
            `pvphong.evaluate`. With `components=True` the
            result has it as arrays, `<name>_visibility_<name or index>` and `<name>_sky`, where it was needed.

        Returns
        -------
        pyvista.PolyData
            The surface with the arrays. It shares points, cells and all other arrays with this dataset, as outputs of
            VTK's filters do: what is written into them in place, on either side, is seen on both. Its ``.copy()``
            stands alone.

        Raises
        ------
        ValueError
            If an argument has the wrong shape, type or range, or the mesh has nothing that can be lit.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
        >>> lit["phong"].shape
        (842, 3)
        """
        return shade_mesh(
            self._mesh,
            scene,
            material,
            name=name,
            matrix=matrix,
            albedo=albedo,
            tangents=tangents,
            maps={"specular": specular, "shininess": shininess, "roughness": roughness},
            components=components,
            tolerance=tolerance,
            precision=precision,
            backend=backend,
            feature_angle=feature_angle,
            occluders=occluders,
            visibility=visibility,
        )

    def visibility(
        self,
        scene: SceneLike | None = None,
        *,
        occluders: Any = (),
        samples: int | None = None,
        tolerance: float = 1.0 / 255.0,
        matrix: MatrixLike | None = None,
        feature_angle: FeatureAngle = None,
    ) -> Visibility:
        """What each vertex sees of each light, and of the sky: arrays to keep, which `shade` takes again.

        Rays are cast when an array is first read. A point, spot or directional light takes one ray for each vertex
        that faces it. A light with a size, and the sky, take 16 where these agree, and more where a shadow's edge is.
        Their nodes are chosen by the vertex's number alone, so that equal calls give equal bits.

        With the extra `rays`, Intel's Embree casts them; without, VTK does, which takes some ten to fifty times as
        long. Faces without an area, or with a corner that is not finite, block nothing. What is nearer to a vertex
        than 2⁻¹⁸ of the size of all meshes of its size together may be missed.

        Parameters
        ----------
        scene : Scene, light, or sequence of lights, optional
            As for `shade`. Its light model need not ask for shadows; its `ambient_occlusion` says up to which distance
            something hides the sky.
        occluders : sequence, optional
            Meshes, or pairs of a mesh and a 4x4 matrix, that are in the way like this mesh itself.
        samples : int, optional
            So many rays for every vertex to each light with a size, and into the sky: the next power of two, at most
            4096.
        tolerance : float, default 1/255
            Else, rays are cast until the standard error of the colour that the light, or the scene's ambient light,
            gives a white surface is at most that; 0 is the default. So what is dim is known less exactly.
        matrix : array_like, optional
            (4, 4) model matrix, as for `shade`.
        feature_angle : float, "auto" or None, default None
            As for `shade`.

        Returns
        -------
        Visibility
            `.per_light` (lights, n), `.sky` (n,), `.standard_error` of both, `.rays` and `.seconds`.

        Raises
        ------
        ValueError
            If an argument is not allowed, or the mesh has nothing that can be lit.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> seen = pv.Sphere().phong.visibility([ph.DirectionalLight(name="sun")])
        >>> seen.per_light.shape
        (1, 842)
        """
        source, _ = split_sharp_edges(surface(self._mesh), feature_angle)
        return visibility_of(
            source,
            cache(lambda: point_normals(source)),
            scene_for(source, scene, matrix),
            occluders=occluders,
            samples=samples,
            tolerance=tolerance,
            matrix=matrix,
        )

    def normals(
        self, weighting: Weighting | None = None, *, matrix: MatrixLike | None = None, backend: Backend = "auto"
    ) -> FloatArray:
        """The point normals that `shade` lights the surface with.

        Parameters
        ----------
        weighting : {"angle", "area", "max"}, optional
            Computes them from the faces with this weighting. Without, the mesh's active point normals as
            they are, if it has any, else weighting by angle.
        matrix : array_like, optional
            (4, 4) model matrix: the normals are transformed by its inverse-transpose and made unit length.
        backend : {"auto", "numpy", "numba"}
            What computes them, where they are computed; see `pvphong.vertex_normals`.

        Returns
        -------
        ndarray
            Shape (n_points, 3), of the surface's points.

        Raises
        ------
        ValueError
            If the mesh has neither normals nor faces, or the matrix or weighting is not allowed.
        """
        normals = point_normals(surface(self._mesh), weighting, backend=backend)
        return normals if matrix is None else transform_normals(normals, matrix)

    def plan(
        self,
        scene: SceneLike | None = None,
        material: Material = _DULL,
        *,
        matrix: MatrixLike | None = None,
        tolerance: float = 0.0,
        feature_angle: FeatureAngle = None,
        specular: Any = None,
        shininess: Any = None,
        roughness: Any = None,
        occluders: Any = (),
        visibility: Visibility | None = None,
    ) -> Plan:
        """Which effects `shade` will run, which it leaves out, and why; see `pvphong.plan`."""
        return plan(
            self._mesh,
            scene,
            material,
            matrix=matrix,
            tolerance=tolerance,
            feature_angle=feature_angle,
            occluders=occluders,
            visibility=visibility,
            maps={"specular": specular, "shininess": shininess, "roughness": roughness},
        )

    def validate(
        self, scene: SceneLike | None = None, material: Material = _DULL, *, matrix: MatrixLike | None = None
    ) -> Comparison:
        """Compare the lit colours with those of VTK's own shader, vertex by vertex; see `pvphong.validate`."""
        from pvphong.studies.validate.validation import validate

        return validate(self._mesh, scene, material, matrix=matrix)

    def refine(
        self,
        scene: SceneLike | None = None,
        material: Material = _DULL,
        *,
        tolerance: float,
        max_points: int | None = None,
        name: str = "phong",
        placement: Placement = "linear",
        matrix: MatrixLike | None = None,
        albedo: Any = None,
        precision: Precision = "float32",
        feature_angle: FeatureAngle = None,
    ) -> pv.PolyData:
        """A new lit mesh, split where colours interpolated across its triangles miss the evaluated ones.

        Triangles are bisected until every error is within the tolerance, or `max_points` are spent; there are no
        T-junctions, and parts keep the shape of what they come from. The result says how it ended:
        ``refined["phong_refinement_summary"]`` in words, ``refined["phong_refinement_reached"]`` yes or no.

        Parameters
        ----------
        scene, material, name, matrix, albedo, precision, feature_angle
            As for `shade`.
        tolerance : float
            Largest absolute colour error that may be left inside triangles, > 0; 1/255 is one step of a display.
        max_points : int, optional
            Points that the result may have, at least those of the mesh; a million more if not given.
        placement : {"linear", "smooth"}
            Where new points lie: on the side that they split, or on a curve that meets the normals of its ends at right
            angles.

        Returns
        -------
        pyvista.PolyData
            Triangles with the lit array, all point and cell arrays carried along, the cell array
            ``<name>_interpolation_error``, and in the field data ``<name>_refinement_reached``, ``_summary``,
            ``_error``, ``_stopped`` and ``_points``; see `pvphong.studies.refine.refinement.refine`.

        Raises
        ------
        ValueError
            If an argument has the wrong shape, type or range, or the mesh has no faces.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> refined = pv.Sphere().phong.refine(ph.PointLight(position=(0, 0, 2)), tolerance=0.01)
        >>> bool(refined["phong_refinement_reached"][0])
        True
        """
        from pvphong.studies.refine.refinement import refine

        return refine(
            self._mesh,
            scene,
            material,
            tolerance=tolerance,
            max_points=max_points,
            name=name,
            placement=placement,
            matrix=matrix,
            albedo=albedo,
            precision=precision,
            feature_angle=feature_angle,
        )

    def interpolation_error(
        self,
        scene: SceneLike | None = None,
        material: Material = _DULL,
        *,
        matrix: MatrixLike | None = None,
        albedo: Any = None,
        feature_angle: FeatureAngle = None,
    ) -> pv.PolyData:
        """A new mesh that says for each triangle how far interpolated colours are from per-pixel shading.

        Parameters
        ----------
        scene, material, matrix, albedo, feature_angle
            As for `shade`.

        Returns
        -------
        pyvista.PolyData
            The surface's triangles with the cell array ``phong_interpolation_error``, active: the largest absolute
            difference of any channel that was found in each. It shares memory as the result of `shade` does.

        Raises
        ------
        ValueError
            If an argument has the wrong shape, type or range, or the mesh has no faces.
        """
        from pvphong.studies.refine.refinement import interpolation_error

        return interpolation_error(
            self._mesh, scene, material, matrix=matrix, albedo=albedo, feature_angle=feature_angle
        )

    def tradeoff(
        self,
        scene: SceneLike | None = None,
        material: Material = _DULL,
        *,
        tolerance: float = 1.0 / 255.0,
        seconds: float = 20.0,
        matrix: MatrixLike | None = None,
        occluders: Any = (),
    ) -> Tradeoff:
        """What accuracy costs in time on this mesh, measured; see `pvphong.studies.accuracy.tradeoff`."""
        from pvphong.studies.accuracy import tradeoff

        how: dict[str, Any] = {"tolerance": tolerance, "seconds": seconds, "matrix": matrix, "occluders": occluders}
        return tradeoff(self._mesh, scene, material, **how)

    def plot(self, *, name: str = "phong", **options: Any) -> Any:
        """Show a lit mesh: the colours as they are, clipped to [0, 1], by PyVista's `plot` and with its options.

        Parameters
        ----------
        name : str, default "phong"
            Name of the array with the colours.
        **options
            As for `pyvista.plot`, such as `screenshot`, `off_screen`, `cpos` or `background`.

        Raises
        ------
        ValueError
            If the mesh has no point array of that name.
        """
        refuse_unlit(self._mesh, name)
        return draw_colors(self._mesh, name, options)

    def color_view(self, space: ColorSpace, *, name: str = "phong") -> pv.PolyData:
        """A new mesh with its lit colours as hue, saturation and value, or as CIE XYZ.

        Parameters
        ----------
        space : {"hsv", "xyz"}
            "hsv": hue and saturation from 0 to 1, and value, the largest channel, which may be above 1. "xyz": CIE X,
            Y and Z of the linear colours, of which Y is the relative luminance. See
            `pvphong.meshes.pictures.color_view`.
        name : str, default "phong"
            Name of the array of colours.

        Returns
        -------
        pyvista.PolyData
            It shares everything with this mesh but the point array ``<name>_<space>``, its active scalars.

        Raises
        ------
        ValueError
            If there is no such array, it holds no colours, or Matplotlib, which "hsv" needs, is not installed.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> lit = pv.Sphere().phong.shade(ph.DirectionalLight())
        >>> luminance = lit.phong.color_view("xyz")["phong_xyz"][:, 1]
        >>> float(luminance.min().round(2))
        0.04
        """
        return color_view(self._mesh, space, name=name)

    def diagnose(self, *, matrix: MatrixLike | None = None) -> Diagnosis:
        """What in the mesh, or in a model matrix for it, will not light as it should; see `pvphong.diagnose`."""
        from pvphong.studies.diagnose.diagnosis import diagnose

        return diagnose(self._mesh, matrix=matrix)
