"""The accessors `mesh.phong` and `blocks.phong`. PyVista imports this module when `phong` is first used.

Most methods of `mesh.phong` are functions of `pvphong.meshes`; methods that measure something are functions of
`pvphong.studies`. Modules that load VTK's rendering are imported on demand. Most methods of `blocks.phong` call the
method of the same name for each block.
"""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import repeat
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar, cast

import numpy as np
import pyvista as pv

from pvphong.base import check
from pvphong.base.display import Tone
from pvphong.base.handles import Handle
from pvphong.base.types import Backend, MatrixLike, Weighting
from pvphong.meshes import daylight as daylights
from pvphong.meshes import irradiance as irradiances
from pvphong.meshes import lit, pictures, saving
from pvphong.meshes import transport as transports
from pvphong.meshes import truth as rendering
from pvphong.meshes.blocks import datasets, leaves, map_blocks, materials_of, of_each
from pvphong.meshes.colormaps import over_all
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.glance import warn_of_normals
from pvphong.meshes.surfaces import FeatureAngle, shallow_copy, surface
from pvphong.meshes.visibility import occluders_of_blocks, visibility_options
from pvphong.optics.material import DEFAULT_MATERIAL, Material, as_material
from pvphong.rays.transport import Transport
from pvphong.rays.visibility import Visibility
from pvphong.scene.options import known_options, refusal_of
from pvphong.scene.scene import Scene, SceneLike
from pvphong.scene.sun import Place
from pvphong.shading.plan.plan import Plan
from pvphong.studies import refine as refinement
from pvphong.studies.diagnose import diagnosis
from pvphong.studies.fitting import fitting
from pvphong.studies.fitting.result import Fit

if TYPE_CHECKING:
    from pvphong.studies.accuracy.report import Tradeoff
    from pvphong.studies.validate.validation import Comparison

# Options of `shade` for its output arrays, and options that define a dataset's surface.
_OF_RUN = "name", "components", "shares_by_bounce", "precision"
_OF_SURFACES = "matrix", "feature_angle"
_OF_LIGHTING = (*_OF_SURFACES, "occluders", "visibility", "transport", "backend")

Options = ParamSpec("Options")
Result = TypeVar("Result")
Method = TypeVar("Method", bound=Callable[..., Any])
Materials = Material | str | Mapping[str, Material | str]


def _of_mesh(
    function: Callable[Concatenate[Any, Options], Result],
) -> Callable[Concatenate[MeshPhong, Options], Result]:
    """Return a method that calls `function` with the accessor's mesh, followed by the method's arguments."""
    refuse = refusal_of(function)

    @functools.wraps(function)
    def method(self: MeshPhong, /, *args: Options.args, **options: Options.kwargs) -> Result:
        refuse(options)
        return function(self._mesh, *args, **options)

    return method


class MeshPhong(Handle):
    """Lighting of one dataset. Results are new datasets and arrays; the dataset is never modified.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> mesh = pv.Sphere()
    >>> mesh.phong
    <phong of a PolyData: 842 points, 1680 cells>
    >>> lit = mesh.phong.shade(ph.DirectionalLight())
    """

    def __init__(self, mesh: pv.DataSet) -> None:
        self._mesh = mesh

    def __repr__(self) -> str:
        mesh = self._mesh
        return f"<phong of a {type(mesh).__name__}: {mesh.n_points} points, {mesh.n_cells} cells>"

    shade = _of_mesh(lit.shade_mesh)
    plan = _of_mesh(lit.plan)
    visibility = _of_mesh(lit.visibility)
    transport = _of_mesh(transports.transport)
    truth = _of_mesh(rendering.truth)
    irradiance = _of_mesh(irradiances.irradiance)
    daylight = _of_mesh(daylights.daylight)
    normals = _of_mesh(lit.normals)
    plot = _of_mesh(pictures.plot)
    save = _of_mesh(saving.save)
    color_view = _of_mesh(pictures.color_view)
    refine = _of_mesh(refinement.refine)
    interpolation_error = _of_mesh(refinement.interpolation_error)
    diagnose = _of_mesh(diagnosis.diagnose)
    fit = _of_mesh(fitting.fit)

    @known_options
    def validate(
        self,
        scene: SceneLike | None = None,
        material: Material | str = DEFAULT_MATERIAL,
        *,
        matrix: MatrixLike | None = None,
        feature_angle: FeatureAngle = None,
        backend: Backend = "auto",
    ) -> Comparison:
        """Compare the lit colours with VTK's own shader, vertex by vertex.

        The parameters and the result are those of `pvphong.validate`.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> pv.Sphere().phong.validate(ph.DirectionalLight()).passed
        True
        """
        from pvphong.studies.validate.validation import validate

        return validate(self._mesh, scene, material, matrix=matrix, feature_angle=feature_angle, backend=backend)

    @known_options
    def tradeoff(
        self,
        scene: SceneLike | None = None,
        material: Material | str = DEFAULT_MATERIAL,
        *,
        tolerance: float = 1.0 / 255.0,
        seconds: float = 20.0,
        matrix: MatrixLike | None = None,
        feature_angle: FeatureAngle = None,
        occluders: Any = (),
        visibility: Visibility | None = None,
        truth: bool = False,
    ) -> Tradeoff:
        """Measure accuracy against time on this mesh.

        The parameters and the result are those of `pvphong.tradeoff`.

        Examples
        --------
        >>> import pyvista as pv, pvphong as ph
        >>> report = pv.Sphere().phong.tradeoff(ph.DirectionalLight(), seconds=0.2)
        """
        from pvphong.studies.accuracy.measure import tradeoff

        how: dict[str, Any] = {"tolerance": tolerance, "seconds": seconds, "matrix": matrix}
        how |= {"feature_angle": feature_angle, "occluders": occluders, "visibility": visibility, "truth": truth}
        return tradeoff(self._mesh, scene, material, **how)


def _options_of(method: Callable[..., Any]) -> Callable[[Method], Method]:
    """Give a method of `BlocksPhong` the signature of `method`, a method of `MeshPhong`.

    help() and completion then show the options of `method`; all other options are refused.
    """
    refuse = refusal_of(method)

    def with_options(own: Method) -> Method:
        @functools.wraps(own)
        def called(self: BlocksPhong, *args: Any, **options: Any) -> Any:
            refuse(options)
            return own(self, *args, **options)

        called.__signature__ = inspect.signature(method)  # type: ignore[attr-defined]
        return cast("Method", called)

    return with_options


class BlocksPhong(Handle):
    """Lighting of every dataset in a MultiBlock. Methods have the same options as those of `MeshPhong`.

    One scene with one viewer lights all blocks, and the blocks shadow each other. `material` is one material for all
    blocks, or a mapping from block names to materials. The name of a nested block is its path, such as "car/wheel".
    Blocks whose name is not a key have the material of the key "default". A map of a material is a texture, or the name
    of an array that every block has.

    A method that makes a mesh from each dataset returns a MultiBlock with the same structure and names; empty blocks
    stay empty. A method that makes another result from each dataset returns a dictionary, block name → result. Errors
    name the block.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> blocks = pv.MultiBlock({"ball": pv.Sphere(), "box": pv.Cube().triangulate()})
    >>> sun = ph.DirectionalLight(direction=(1, 1, -2))
    >>> lit = blocks.phong.shade(sun, {"ball": "gold", "default": "silver"})
    >>> lit["ball"]["phong"].shape
    (842, 3)
    >>> lit.phong.color_view("hsv")["ball"]["phong_hsv"].shape
    (842, 3)
    >>> lit.phong.save("lit.vtm")
    >>> lit.phong.plot(off_screen=True)
    >>> blocks.phong.plan(sun)["ball"].view_dependent
    False
    >>> blocks.phong.visibility(sun)["ball"].per_light.shape
    (1, 842)
    >>> blocks.phong.truth(sun, samples=4)["box"].rgb.shape
    (8, 3)
    >>> blocks.phong.irradiance(sun)["box"]["irradiance_light_0"].shape
    (8, 3)
    >>> blocks.phong.daylight("2026-06-21T10:00Z", ph.Place(48.14, 11.58))["box"].sun_hours.shape
    (8,)
    >>> transport = blocks.phong.transport(samples=16)
    >>> [str(found) for found in blocks.phong.diagnose().values()]
    ['Diagnosis of 842 points and 1680 faces: ok', 'Diagnosis of 8 points and 12 faces: ok']
    >>> blocks.phong.normals()["box"].n_points
    8
    >>> blocks.phong.refine(sun, tolerance=0.1, max_points=2000).keys()
    ['ball', 'box']
    >>> blocks.phong.interpolation_error(sun).keys()
    ['ball', 'box']
    >>> [each.passed for each in blocks.phong.validate(sun).values()]
    [True, True]
    >>> report = blocks.phong.tradeoff(sun, seconds=0.2)
    >>> fit = blocks.phong.fit(sun, "gold", {"ball": 0.5}, {"0": "intensity"})
    """

    def __init__(self, blocks: pv.MultiBlock) -> None:
        self._blocks = blocks

    def __repr__(self) -> str:
        return f"<phong of a MultiBlock: {self._blocks.n_blocks} blocks>"

    @_options_of(MeshPhong.shade)
    def shade(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> pv.MultiBlock:
        """Return a new MultiBlock of lit meshes.

        The options `visibility` and `transport` accept the results of the methods of the same names.
        """
        scene = self._scene(scene, options)
        run = {name: options.pop(name) for name in _OF_RUN if name in options}
        run["backend"] = options.get("backend", "auto")  # stays in options: normals use it too
        if not scene.light_model.bounces:
            return lit.shade_blocks(self._blocks, scene, self._own(scene, material, options), **run)
        among = self._exchanging(options)
        own = self._own(scene, material, options, among.parts)

        def prepare(block: pv.DataSet) -> lit.Prepared:
            its_material, how = next(own)
            return lit.prepare(block, scene, its_material, lit.Setting(**how))

        prepared = of_each(self._blocks, prepare)
        for each in prepared:
            warn_of_normals(each.mesh, each.source, scene, options.get("matrix"))
        results = lit.lit_together(prepared, among, **run)
        return map_blocks(self._blocks, lambda _: next(results))

    @_options_of(MeshPhong.plan)
    def plan(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> dict[str, Plan]:
        """Return a plan, the simplified lighting equation, for each dataset.

        The option `visibility` accepts the result of the method `visibility`.
        """
        scene = self._scene(scene, options)
        parts = self._exchanging(options).parts if scene.light_model.bounces else None
        return self._by_path(self._each("plan", scene, self._own(scene, material, options, parts)))

    @_options_of(MeshPhong.visibility)
    def visibility(self, scene: SceneLike | None = None, **options: Any) -> dict[str, Visibility]:
        """Return the visibility of lights and sky for each dataset, as block name → result.

        Blocks may block each other's light.
        """
        scene = self._scene(scene, options)
        among = occluders_of_blocks(self._blocks, options.get("matrix"), options.pop("occluders", ()))
        return self._by_path(lambda block: block.phong.visibility(scene, occluders=next(among), **options))

    @_options_of(MeshPhong.transport)
    def transport(self, **options: Any) -> Transport:
        """Compute the light transport between the vertices of all datasets, in the order of the datasets."""
        return transports.transport_of(self._surfaces(*(options.pop(name, None) for name in _OF_SURFACES)), **options)

    @_options_of(MeshPhong.truth)
    def truth(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> dict[str, rendering.Truth]:
        """Compute the colours of each dataset from the rendering equation, as block name → result.

        Blocks reflect light to each other.
        """
        where = {name: options.pop(name) for name in (*_OF_SURFACES, "occluders") if name in options}
        scene = self._scene(scene, where)
        among = rendering.reflecting_blocks(self._blocks, scene, self._materials(material), **where)
        return self._by_path(lambda block: block.phong.truth(scene, occluders=next(among), **options))

    @_options_of(MeshPhong.irradiance)
    def irradiance(
        self,
        scene: SceneLike | None = None,
        *,
        per: irradiances.Per = "vertex",
        albedo: Any = irradiances.ALBEDO,
        feature_angle: FeatureAngle = None,
        **options: Any,
    ) -> pv.MultiBlock:
        """Return a new MultiBlock with the irradiance of each block. Blocks reflect light to each other.

        `albedo` may be a mapping from block names to albedos, as for materials.
        """
        scene, how = self._scene(scene, options), (feature_angle, options.get("backend", "auto"))
        own = iter(self._albedos(albedo))
        parts = of_each(self._blocks, lambda block: irradiances.Receiving.of(block, per, next(own), *how))
        seen = options.pop("visibility", None)
        if seen is not None:
            seen = [each["visibility"] for each in visibility_options(self._blocks, scene, {"visibility": seen})]
        found = iter(irradiances.irradiance_together(parts, scene, per=per, visibility=seen or (), **options))
        return map_blocks(self._blocks, lambda _: next(found))

    @_options_of(MeshPhong.daylight)
    def daylight(self, times: Any, place: Place, weather: Any = None, **options: Any) -> dict[str, daylights.Daylight]:
        """Return the light of sun and sky on each dataset.

        Other blocks may block light, but reflect none.
        """
        if options.get("bounces"):
            remedy = "Join the blocks for bounces: blocks.combine().extract_surface().phong.daylight(...)."
            check.refuse("bounces", options["bounces"], "0 for blocks", remedy)
        among = occluders_of_blocks(self._blocks, options.get("matrix"), options.pop("occluders", ()))
        return self._by_path(
            lambda block: block.phong.daylight(times, place, weather, occluders=next(among), **options)
        )

    @_options_of(MeshPhong.normals)
    def normals(self, weighting: Weighting | None = None, **options: Any) -> pv.MultiBlock:
        """Return a new MultiBlock of surfaces with active point normals.

        Each surface shares points, cells and arrays with its block, as results of `shade` do.
        """

        def with_normals(block: pv.DataSet) -> pv.PolyData:
            result = shallow_copy(surface(block))
            result.point_data.active_normals = block.phong.normals(weighting, **options)
            return result

        return map_blocks(self._blocks, with_normals)

    @_options_of(MeshPhong.refine)
    def refine(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> pv.MultiBlock:
        """Return a new MultiBlock of meshes, each refined separately; `max_points` is per block."""
        return self._inside("refine", scene, material, options)

    @_options_of(MeshPhong.interpolation_error)
    def interpolation_error(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> pv.MultiBlock:
        """Return a new MultiBlock of meshes with the errors of interpolated colours inside triangles."""
        return self._inside("interpolation_error", scene, material, options)

    @_options_of(MeshPhong.validate)
    def validate(
        self, scene: SceneLike | None = None, material: Materials = DEFAULT_MATERIAL, **options: Any
    ) -> dict[str, Comparison]:
        """Compare the lit colours of each dataset with VTK's shader."""
        scene = self._scene(scene, options)
        own = zip(self._materials(material), repeat(options), strict=False)
        return self._by_path(self._each("validate", scene, own))

    @_options_of(MeshPhong.tradeoff)
    def tradeoff(
        self,
        scene: SceneLike | None = None,
        material: Material | str = DEFAULT_MATERIAL,
        *,
        feature_angle: FeatureAngle = None,
        **options: Any,
    ) -> Tradeoff:
        """Measure accuracy against time on all blocks, which are joined into one surface with one material."""
        from pvphong.studies.accuracy.measure import tradeoff

        return tradeoff(lit.one_surface(self._blocks, feature_angle), scene, material, **options)

    @_options_of(MeshPhong.diagnose)
    def diagnose(self, **options: Any) -> dict[str, diagnosis.Diagnosis]:
        """Return a diagnosis of each dataset, as block name → result."""
        return self._by_path(lambda block: block.phong.diagnose(**options))

    @_options_of(MeshPhong.fit)
    def fit(self, scene: SceneLike | None, material: Materials, target: Any, vary: Any, **options: Any) -> Fit:
        """Find the lights with which the blocks get the colours that they should have.

        `target` and `weights` are mappings from paths of blocks to arrays, as `pvphong.target` makes for blocks. Blocks
        without an entry do not count. A number is the luminance of all blocks.
        """
        scene = self._scene(scene, options)
        how = {name: options[name] for name in _OF_LIGHTING if name in options}
        light = functools.partial(self.shade, material=material, **how)
        return fitting.fit_blocks(self._blocks, scene, self._materials(material), target, vary, options, light)

    def plot(self, *, name: str = "phong", exposure: float = 0.0, tone: Tone = "none", **options: Any) -> Any:
        """Show lit blocks in one picture; see `MeshPhong.plot`."""
        lit_blocks = pv.MultiBlock(leaves(self._blocks))  # without tables and empty meshes
        for block in lit_blocks:
            pictures.refuse_unlit(block, name)
        together = lit_blocks.combine()  # PyVista ignores `rgb` for a MultiBlock
        for block in lit_blocks:
            together.field_data.update(block.field_data)  # for the scalar bar
        return pictures.plot(together, name=name, exposure=exposure, tone=tone, **options)

    @_options_of(MeshPhong.color_view)
    def color_view(self, space: pictures.ColorSpace, **options: Any) -> pv.MultiBlock:
        """Return a new MultiBlock with the blocks' lit colours in another colour space."""
        return map_blocks(self._blocks, lambda block: block.phong.color_view(space, **options))

    @_options_of(MeshPhong.save)
    def save(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write lit blocks to a .vtm, .vtmb, .vtkhdf, .glb, .gltf or .png file; see `MeshPhong.save`."""
        saving.save(self._blocks, path, **options)

    def _scene(self, given: SceneLike | None, options: Mapping[str, Any]) -> Scene:
        """Return the scene of all blocks: `given`, or else the default scene.

        A scene without a viewer gets PyVista's default camera, which frames all blocks.
        """
        if isinstance(given, Scene) and given.viewer is not None:
            return given
        return scene_for(map_blocks(self._blocks, surface), given, options.get("matrix"))

    def _own(
        self, scene: Scene, material: Materials, options: dict[str, Any], transports: Iterable[Any] | None = None
    ) -> Iterator[tuple[Material | str, dict[str, Any]]]:
        """Yield the material and the options of each dataset, in order.

        The options of a dataset are a copy of `options`. In the copy, `visibility` and `occluders` are those of this
        dataset, not of all blocks. `transports` are the datasets' parts of a light transport. If given, they become
        the option `transport`.
        """
        materials, own = self._materials(material), visibility_options(self._blocks, scene, options)
        if transports is not None:
            own = ({**how, "transport": each} for how, each in zip(own, transports, strict=False))
        return zip(materials, own, strict=False)

    def _each(
        self, method: str, scene: Scene, own: Iterator[tuple[Material | str, dict[str, Any]]]
    ) -> Callable[[pv.DataSet], Any]:
        """Return a function of a dataset that calls the dataset's method `phong.<method>` with the common scene.

        The function must be called once for each dataset, in order: each call takes the next material and options from
        `own`.
        """

        def call(block: pv.DataSet) -> Any:
            material, how = next(own)
            return getattr(block.phong, method)(scene, material, **how)

        return call

    def _inside(
        self, method: str, scene: SceneLike | None, material: Materials, options: dict[str, Any]
    ) -> pv.MultiBlock:
        """Call a method of each block with the same scene, and return a MultiBlock of the resulting meshes.

        `method` is "refine" or "interpolation_error". Both methods evaluate colours inside triangles. Light that
        bounces between the blocks is computed only at their vertices, and blended across the triangles.
        """
        scene, bounced = self._scene(scene, options), None
        if scene.light_model.bounces:
            how = {name: options[name] for name in (*_OF_SURFACES, "occluders", "transport") if name in options}
            lit_blocks = self.shade(scene, material, name="pvphong", components=True, precision="float64", **how)
            bounced = (
                refinement.BouncedLight(np.array(b.point_data.get("pvphong_bounced", np.zeros((b.n_points, 3)))))
                for _, b in datasets(lit_blocks)  # a single dataset may have no such array
            )
        return map_blocks(self._blocks, self._each(method, scene, self._own(scene, material, options, bounced)))

    def _surfaces(self, matrix: MatrixLike | None, feature_angle: FeatureAngle) -> list[transports.Exchanging]:
        """Return all datasets as surfaces that exchange light by reflection.

        `matrix` is the model matrix of all. Edges are split if the normals of their faces differ by more than
        `feature_angle`, in degrees.
        """
        return of_each(self._blocks, lambda block: transports.Exchanging.of(block, matrix, feature_angle))

    def _exchanging(self, options: dict[str, Any]) -> Transport:
        """Return the light transport between the blocks: the option `transport`, or else a new transport.

        The option is removed from `options`. A new transport casts its rays when they are needed.
        """
        given, occluders = options.pop("transport", None), options.get("occluders", ())
        surfaces = self._surfaces(*(options.get(name) for name in _OF_SURFACES))
        return transports.checked_transport(given, surfaces, occluders)

    def _materials(self, material: Materials) -> list[Material]:
        """Return the material of each dataset, in order.

        A colormap without a range gets the range of its array in all blocks.
        """
        if not isinstance(material, Mapping):
            meshes = leaves(self._blocks)
            return [over_all(as_material(material), meshes)] * len(meshes)
        blocks = list(datasets(self._blocks))
        own = {name: over_all(as_material(each), [block for _, block in blocks]) for name, each in material.items()}
        return materials_of([path for path, _ in blocks], own)

    def _albedos(self, albedo: Any) -> list[Any]:
        """Return each dataset's albedo, in order. `albedo` is that of all, or a mapping from block names to albedos."""
        paths = [path for path, _ in datasets(self._blocks)]
        return materials_of(paths, albedo, "albedo") if isinstance(albedo, Mapping) else [albedo] * len(paths)

    def _by_path(self, operation: Callable[[pv.DataSet], Any]) -> dict[str, Any]:
        paths = [path for path, _ in datasets(self._blocks)]
        return dict(zip(paths, of_each(self._blocks, operation), strict=True))


# Not as decorators: these return a bare `type`, which hides the classes' methods from type checkers and editors.
pv.register_dataset_accessor("phong", pv.DataSet)(MeshPhong)
pv.register_dataset_accessor("phong", pv.MultiBlock)(BlocksPhong)
