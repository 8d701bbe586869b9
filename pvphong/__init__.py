"""Lighting as data for PyVista and VTK.

`import pvphong as ph` gives the names below; `mesh.phong` and `plotter.phong` are there even without it, for PyVista
finds them by this package's entry points.
A name is imported when it is first asked for: the command line's supervisor must stay light, and computing colours
needs neither what draws nor what measures.
"""

from pvphong.base import host as _host

TYPE_CHECKING = False  # typing's is the same, and takes milliseconds to import
if TYPE_CHECKING:
    from typing import Any

    from pvphong.batch.shading import Batch, shade_files
    from pvphong.chunks import evaluate
    from pvphong.filter import PhongFilter
    from pvphong.geometry.normals import implicit_normals, plane_normal
    from pvphong.geometry.projection import frustum, look_at, ortho, perspective, project
    from pvphong.geometry.transform import (
        SingularMatrixWarning,
        normal_matrix,
        transform_normals,
        transform_points,
        transform_vectors,
    )
    from pvphong.meshes.default_scene import default_scene
    from pvphong.meshes.files import read
    from pvphong.meshes.lit import plan
    from pvphong.meshes.surfaces import face_normals, vertex_normals
    from pvphong.optics.lights import (
        DirectionalLight,
        DiskLight,
        EnvironmentLight,
        Light,
        PointLight,
        PolygonLight,
        RectangleLight,
        SphereLight,
        SpotLight,
        light_from_homogeneous,
    )
    from pvphong.optics.material import Material
    from pvphong.optics.reflectances import GGX, PBR, BlinnPhong, Metal, ModifiedPhong, OrenNayar, Phong, Retro, Ward
    from pvphong.rays.visibility import Visibility
    from pvphong.scene.light_model import LightModel
    from pvphong.scene.presets import three_lights, three_point
    from pvphong.scene.scene import Scene, load_materials
    from pvphong.scene.viewer import Viewer
    from pvphong.shading.plan.draft import Decision
    from pvphong.shading.plan.plan import Plan
    from pvphong.shading.result import Shading
    from pvphong.studies.accuracy.measure import tradeoff
    from pvphong.studies.accuracy.report import Tradeoff
    from pvphong.studies.diagnose.diagnosis import Diagnosis, diagnose
    from pvphong.studies.validate.comparison import Comparison
    from pvphong.studies.validate.validation import validate
    from pvphong.vtk.lights import as_light, light_kit
    from pvphong.vtk.oracle import vtk_shade


def _answer_the_core() -> None:
    from pvphong.vtk.lights import answer_the_core

    answer_the_core()


_host.answered_after(_answer_the_core)

_PLACES = {
    "batch.shading": "Batch shade_files",
    "chunks": "evaluate",
    "filter": "PhongFilter",
    "geometry.normals": "implicit_normals plane_normal",
    "geometry.projection": "frustum look_at ortho perspective project",
    "geometry.transform": "SingularMatrixWarning normal_matrix transform_normals transform_points transform_vectors",
    "meshes.default_scene": "default_scene",
    "meshes.files": "read",
    "meshes.lit": "plan",
    "meshes.surfaces": "face_normals vertex_normals",
    "optics.lights": "DirectionalLight DiskLight EnvironmentLight Light PointLight PolygonLight RectangleLight "
    "SphereLight SpotLight light_from_homogeneous",
    "optics.material": "Material",
    "optics.reflectances": "GGX PBR BlinnPhong Metal ModifiedPhong OrenNayar Phong Retro Ward",
    "rays.visibility": "Visibility",
    "scene.light_model": "LightModel",
    "scene.presets": "three_lights three_point",
    "scene.scene": "Scene load_materials",
    "scene.viewer": "Viewer",
    "shading.plan.draft": "Decision",
    "shading.plan.plan": "Plan",
    "shading.result": "Shading",
    "studies.accuracy.measure": "tradeoff",
    "studies.accuracy.report": "Tradeoff",
    "studies.diagnose.diagnosis": "Diagnosis diagnose",
    "studies.validate.comparison": "Comparison",
    "studies.validate.validation": "validate",
    "vtk.lights": "as_light light_kit",
    "vtk.oracle": "vtk_shade",
}
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names.split()}


def __getattr__(name: str) -> "Any":
    if name not in _PLACE_OF:
        raise AttributeError(f"module 'pvphong' has no attribute {name!r}")
    from importlib import import_module

    value = globals()[name] = getattr(import_module(f"pvphong.{_PLACE_OF[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "GGX",
    "PBR",
    "Batch",
    "BlinnPhong",
    "Comparison",
    "Decision",
    "Diagnosis",
    "DirectionalLight",
    "DiskLight",
    "EnvironmentLight",
    "Light",
    "LightModel",
    "Material",
    "Metal",
    "ModifiedPhong",
    "OrenNayar",
    "Phong",
    "PhongFilter",
    "Plan",
    "PointLight",
    "PolygonLight",
    "RectangleLight",
    "Retro",
    "Scene",
    "Shading",
    "SingularMatrixWarning",
    "SphereLight",
    "SpotLight",
    "Tradeoff",
    "Viewer",
    "Visibility",
    "Ward",
    "as_light",
    "default_scene",
    "diagnose",
    "evaluate",
    "face_normals",
    "frustum",
    "implicit_normals",
    "light_from_homogeneous",
    "light_kit",
    "load_materials",
    "look_at",
    "normal_matrix",
    "ortho",
    "perspective",
    "plan",
    "plane_normal",
    "project",
    "read",
    "shade_files",
    "three_lights",
    "three_point",
    "tradeoff",
    "transform_normals",
    "transform_points",
    "transform_vectors",
    "validate",
    "vertex_normals",
    "vtk_shade",
]
