"""`blocks.phong`: lighting on MultiBlock, each dataset in it by its own `phong`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import pyvista as pv

from pvphong.accessor.drawing import draw_colors, refuse_unlit
from pvphong.base.types import MatrixLike, Precision, Weighting
from pvphong.meshes.blocks import DEFAULT, datasets, map_blocks, materials_of
from pvphong.meshes.default_scene import scene_for
from pvphong.meshes.lit import one_surface
from pvphong.meshes.pictures import ColorSpace
from pvphong.meshes.surfaces import FeatureAngle, shallow_copy, surface
from pvphong.meshes.visibility import occluders_of_blocks, visibility_options
from pvphong.optics.material import Material
from pvphong.rays.visibility import Visibility
from pvphong.scene.scene import Scene, SceneLike
from pvphong.shading.plan.plan import Plan

if TYPE_CHECKING:
    from pvphong.studies.accuracy import Tradeoff
    from pvphong.studies.diagnose.diagnosis import Diagnosis
    from pvphong.studies.refine.refinement import Placement
    from pvphong.studies.validate.comparison import Comparison

_DULL = Material()


@pv.register_dataset_accessor("phong", pv.MultiBlock)
class BlocksPhong:
    """Lighting of every dataset in a MultiBlock; structure and names are kept, None stays None."""

    def __init__(self, blocks: pv.MultiBlock) -> None:
        self._blocks = blocks

    def __repr__(self) -> str:
        return f"<phong of a MultiBlock: {self._blocks.n_blocks} blocks>"

    def shade(
        self, scene: SceneLike | None = None, material: Material | Mapping[str, Material] = _DULL, **options: Any
    ) -> pv.MultiBlock:
        """A new MultiBlock of lit meshes; an empty block stays empty.

        Parameters
        ----------
        scene : Scene, light, or sequence of lights, optional
            As for a single dataset.
        material : Material or mapping, optional
            One for all, or block's name → material; of a block inside a block the names with "/" between them. Blocks
            that are not named have that of the name "default".
        **options
            As for a single dataset; `albedo` is a texture, or the name of a point array that every block has, and
            `visibility` is what `visibility` gives. Blocks shadow each other.

        Raises
        ------
        ValueError
            As for a single dataset; the message names the block.
        """
        scene = self._scene(scene, options.get("matrix"))
        materials, rays = self._materials(material), visibility_options(self._blocks, scene, options)
        return map_blocks(self._blocks, lambda block: block.phong.shade(scene, next(materials), **next(rays)))

    def visibility(self, scene: SceneLike | None = None, **options: Any) -> dict[str, Visibility]:
        """What the vertices of each dataset see, by the path of its block's names; blocks are in each other's way.

        `options` are those for a single dataset. `shade` and `plan` take the result as `visibility`.
        """
        scene = self._scene(scene, options.get("matrix"))
        among = occluders_of_blocks(self._blocks, options.get("matrix"), options.pop("occluders", ()))
        return {
            path: block.phong.visibility(scene, occluders=next(among), **options)
            for path, block in datasets(self._blocks)
        }

    def plot(self, *, name: str = "phong", **options: Any) -> Any:
        """Show lit blocks: the colours as they are; see `MeshPhong.plot`."""
        for _, block in datasets(self._blocks):
            refuse_unlit(block, name)
        return draw_colors(self._blocks.combine(), name, options)  # drawn one by one they would ignore `rgb`

    def color_view(self, space: ColorSpace, *, name: str = "phong") -> pv.MultiBlock:
        """A new MultiBlock with the blocks' lit colours in other terms; see `MeshPhong.color_view`."""
        return map_blocks(self._blocks, lambda block: block.phong.color_view(space, name=name))

    def normals(self, weighting: Weighting | None = None, *, matrix: MatrixLike | None = None) -> pv.MultiBlock:
        """A new MultiBlock of surfaces that carry their normals as active point normals.

        Each shares points, cells and arrays with its block, as results of `shade` do.
        """

        def with_normals(block: pv.DataSet) -> pv.PolyData:
            result = shallow_copy(surface(block))
            result.point_data.active_normals = block.phong.normals(weighting, matrix=matrix)
            return result

        return map_blocks(self._blocks, with_normals)

    def diagnose(self, *, matrix: MatrixLike | None = None) -> dict[str, Diagnosis]:
        """A diagnosis for each dataset, by the path of its block's names; None and empty blocks are left out."""
        return {path: block.phong.diagnose(matrix=matrix) for path, block in datasets(self._blocks)}

    def plan(
        self,
        scene: SceneLike | None = None,
        material: Material | Mapping[str, Material] = _DULL,
        *,
        matrix: MatrixLike | None = None,
        tolerance: float = 0.0,
        feature_angle: FeatureAngle = None,
        occluders: Any = (),
        visibility: Mapping[str, Visibility] | None = None,
    ) -> dict[str, Plan]:
        """A plan for each dataset, by the path of its block's names; None and empty blocks are left out.

        `material` may be a mapping, as for `shade`.
        """
        scene, materials = self._scene(scene, matrix), self._materials(material)
        options = {"matrix": matrix, "tolerance": tolerance, "occluders": occluders, "visibility": visibility}
        rays = visibility_options(self._blocks, scene, options)
        return {
            path: block.phong.plan(scene, next(materials), feature_angle=feature_angle, **next(rays))
            for path, block in datasets(self._blocks)
        }

    def refine(
        self,
        scene: SceneLike | None = None,
        material: Material | Mapping[str, Material] = _DULL,
        *,
        tolerance: float,
        max_points: int | None = None,
        name: str = "phong",
        placement: Placement = "linear",
        matrix: MatrixLike | None = None,
        albedo: Any = None,
        precision: Precision = "float32",
        feature_angle: FeatureAngle = None,
    ) -> pv.MultiBlock:
        """A new MultiBlock of refined meshes, each block by itself; see `MeshPhong.refine`.

        `material` may be a mapping, as for `shade`; `max_points` is for each block, `albedo` a texture, or the name of
        a point array that every block has.
        """
        scene, materials = self._scene(scene, matrix), self._materials(material)
        return map_blocks(
            self._blocks,
            lambda block: block.phong.refine(
                scene,
                next(materials),
                tolerance=tolerance,
                max_points=max_points,
                name=name,
                placement=placement,
                matrix=matrix,
                albedo=albedo,
                precision=precision,
                feature_angle=feature_angle,
            ),
        )

    def interpolation_error(
        self,
        scene: SceneLike | None = None,
        material: Material | Mapping[str, Material] = _DULL,
        *,
        matrix: MatrixLike | None = None,
        albedo: Any = None,
        feature_angle: FeatureAngle = None,
    ) -> pv.MultiBlock:
        """A new MultiBlock of meshes with the errors inside triangles; see `MeshPhong.interpolation_error`.

        `material` may be a mapping, as for `shade`; `albedo` is a texture, or the name of a point array that every
        block has.
        """
        scene, materials = self._scene(scene, matrix), self._materials(material)
        return map_blocks(
            self._blocks,
            lambda block: block.phong.interpolation_error(
                scene, next(materials), matrix=matrix, albedo=albedo, feature_angle=feature_angle
            ),
        )

    def validate(
        self,
        scene: SceneLike | None = None,
        material: Material | Mapping[str, Material] = _DULL,
        *,
        matrix: MatrixLike | None = None,
    ) -> dict[str, Comparison]:
        """A comparison with VTK for each dataset, by the path of its block's names; see `pvphong.validate`.

        `material` may be a mapping, as for `shade`.
        """
        scene, materials = self._scene(scene, matrix), self._materials(material)
        return {
            path: block.phong.validate(scene, next(materials), matrix=matrix) for path, block in datasets(self._blocks)
        }

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
        """What accuracy costs in time on all blocks together, as one surface; see `pvphong.tradeoff`."""
        from pvphong.studies.accuracy import tradeoff

        how: dict[str, Any] = {"tolerance": tolerance, "seconds": seconds, "matrix": matrix, "occluders": occluders}
        return tradeoff(one_surface(self._blocks), scene, material, **how)

    def _scene(self, given: SceneLike | None, matrix: MatrixLike | None) -> Scene:
        """One viewer for all blocks."""
        return scene_for(map_blocks(self._blocks, surface), given, matrix)

    def _materials(self, given: Material | Mapping[str, Material]) -> Iterator[Material]:
        """Of each block."""
        return materials_of(self._blocks, given if isinstance(given, Mapping) else {DEFAULT: given})
