"""Lighting as data for PyVista and VTK.

`import pvphong as ph` gives the names below; `mesh.phong` and `plotter.phong` are there in PyVista even without it.
The plotter's part is not imported here: it would load all of PyVista's plotting, which computing colours does not need.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from pvphong import accessor as accessor  # registers mesh.phong
from pvphong.filter import PhongFilter
from pvphong.geometry.normals import implicit_normals, plane_normal
from pvphong.geometry.transform import (
    SingularMatrixWarning,
    normal_matrix,
    transform_normals,
    transform_points,
    transform_vectors,
)
from pvphong.meshes.lit import plan
from pvphong.meshes.surfaces import face_normals, vertex_normals
from pvphong.optics.lights import DirectionalLight, Light, PointLight, SphereLight, SpotLight, light_from_homogeneous
from pvphong.optics.material import Material
from pvphong.optics.reflectances import BlinnPhong, OrenNayar, Phong
from pvphong.rays.visibility import Visibility
from pvphong.scene.light_model import LightModel
from pvphong.scene.scene import Scene, load_materials
from pvphong.scene.viewer import Viewer
from pvphong.shading.evaluation import evaluate
from pvphong.shading.plan.draft import Decision
from pvphong.shading.plan.plan import Plan
from pvphong.shading.result import Shading
from pvphong.vtk import host as host  # answers what the core asks of PyVista
from pvphong.vtk.lights import as_light

if TYPE_CHECKING:
    from pvphong.geometry.projection import frustum, look_at, ortho, perspective, project
    from pvphong.meshes.default_scene import default_scene
    from pvphong.studies.accuracy import Tradeoff, tradeoff
    from pvphong.studies.diagnose.diagnosis import Diagnosis, diagnose
    from pvphong.studies.validate.comparison import Comparison
    from pvphong.studies.validate.validation import validate
    from pvphong.vtk.oracle import vtk_shade
    from pvphong.vtk.presets import light_kit, three_lights, three_point

# What colours do not need is imported when it is first asked for: some of it draws with VTK, and all takes time.
_LATER = {
    "Comparison": "studies.validate.comparison",
    "Diagnosis": "studies.diagnose.diagnosis",
    "Tradeoff": "studies.accuracy",
    "default_scene": "meshes.default_scene",
    "diagnose": "studies.diagnose.diagnosis",
    "frustum": "geometry.projection",
    "light_kit": "vtk.presets",
    "look_at": "geometry.projection",
    "ortho": "geometry.projection",
    "perspective": "geometry.projection",
    "project": "geometry.projection",
    "three_lights": "vtk.presets",
    "three_point": "vtk.presets",
    "tradeoff": "studies.accuracy",
    "validate": "studies.validate.validation",
    "vtk_shade": "vtk.oracle",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'pvphong' has no attribute {name!r}")
    return getattr(import_module(f"pvphong.{_LATER[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


__all__ = [
    "BlinnPhong",
    "Comparison",
    "Decision",
    "Diagnosis",
    "DirectionalLight",
    "Light",
    "LightModel",
    "Material",
    "OrenNayar",
    "Phong",
    "PhongFilter",
    "Plan",
    "PointLight",
    "Scene",
    "Shading",
    "SingularMatrixWarning",
    "SphereLight",
    "SpotLight",
    "Tradeoff",
    "Viewer",
    "Visibility",
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
