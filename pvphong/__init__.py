"""Lighting as data for PyVista and VTK.

`import pvphong as ph` gives the names below. `mesh.phong` and `plotter.phong` work even without this import, because
PyVista finds them through this package's entry points. Each name is imported on first use. So the command line starts
quickly, and lighting a mesh loads neither VTK's rendering nor the studies.

The packages, from the lowest layer to the highest: `base`, `geometry`, `optics` (lights, reflectances, materials),
`scene`, `shading` (the equation, its plan, its two evaluators), `rays`, `meshes` (PyVista's data in and out), `vtk` and
`batch`, `studies`, `studio`, `cli`. The modules next to them: `accessor` has `mesh.phong`, `plotter` has
`plotter.phong`, `filter` has the VTK filter, `chunks` lights Dask arrays, `pipeline` has functions for normals,
matrices and coordinates, and `report` lists versions and hardware.
"""

from pvphong.base import host as _host

TYPE_CHECKING = False  # type checkers know this name too; importing typing takes milliseconds
if TYPE_CHECKING:  # the alias tells a type checker that a name is public
    from typing import Any

    from pvphong import pipeline as pipeline
    from pvphong.accessor import BlocksPhong as BlocksPhong
    from pvphong.accessor import MeshPhong as MeshPhong
    from pvphong.base.color import kelvin as kelvin
    from pvphong.base.display import Display as Display
    from pvphong.batch.daylight import daylight_files as daylight_files
    from pvphong.batch.run import Batch as Batch
    from pvphong.batch.shading import shade_files as shade_files
    from pvphong.chunks import evaluate as evaluate
    from pvphong.filter import PhongFilter as PhongFilter
    from pvphong.geometry.transform import SingularMatrixWarning as SingularMatrixWarning
    from pvphong.meshes.daylight import Daylight as Daylight
    from pvphong.meshes.default_scene import default_scene as default_scene
    from pvphong.meshes.files import read as read
    from pvphong.meshes.glance import NormalsWarning as NormalsWarning
    from pvphong.meshes.lit import plan as plan
    from pvphong.meshes.stages import stage as stage
    from pvphong.meshes.truth import Truth as Truth
    from pvphong.optics.colormap import Colormap as Colormap
    from pvphong.optics.lights import DirectionalLight as DirectionalLight
    from pvphong.optics.lights import DiskLight as DiskLight
    from pvphong.optics.lights import EnvironmentLight as EnvironmentLight
    from pvphong.optics.lights import Light as Light
    from pvphong.optics.lights import PhotometricLight as PhotometricLight
    from pvphong.optics.lights import PointLight as PointLight
    from pvphong.optics.lights import PolygonLight as PolygonLight
    from pvphong.optics.lights import RectangleLight as RectangleLight
    from pvphong.optics.lights import SphereLight as SphereLight
    from pvphong.optics.lights import SpotLight as SpotLight
    from pvphong.optics.material import Material as Material
    from pvphong.optics.reflectances import GGX as GGX
    from pvphong.optics.reflectances import PBR as PBR
    from pvphong.optics.reflectances import BlinnPhong as BlinnPhong
    from pvphong.optics.reflectances import Metal as Metal
    from pvphong.optics.reflectances import ModifiedPhong as ModifiedPhong
    from pvphong.optics.reflectances import OrenNayar as OrenNayar
    from pvphong.optics.reflectances import Phong as Phong
    from pvphong.optics.reflectances import Retro as Retro
    from pvphong.optics.reflectances import Ward as Ward
    from pvphong.plotter import PlotterPhong as PlotterPhong
    from pvphong.rays.transport import Transport as Transport
    from pvphong.rays.visibility import Visibility as Visibility
    from pvphong.report import Report as Report
    from pvphong.scene.daylight import daylight_scene as daylight_scene
    from pvphong.scene.light_model import LightModel as LightModel
    from pvphong.scene.presets import setups as setups
    from pvphong.scene.presets import three_point as three_point
    from pvphong.scene.scene import Scene as Scene
    from pvphong.scene.scene import load_materials as load_materials
    from pvphong.scene.sun import Place as Place
    from pvphong.scene.sun import sun_position as sun_position
    from pvphong.scene.viewer import Viewer as Viewer
    from pvphong.shading.plan.plan import Plan as Plan
    from pvphong.shading.reference import Shading as Shading
    from pvphong.studies.accuracy.measure import tradeoff as tradeoff
    from pvphong.studies.accuracy.report import Tradeoff as Tradeoff
    from pvphong.studies.diagnose.diagnosis import Diagnosis as Diagnosis
    from pvphong.studies.diagnose.diagnosis import diagnose as diagnose
    from pvphong.studies.fitting.image import colors_from_image as colors_from_image
    from pvphong.studies.fitting.result import Fit as Fit
    from pvphong.studies.fitting.target import target as target
    from pvphong.studies.validate.validation import Comparison as Comparison
    from pvphong.studies.validate.validation import validate as validate
    from pvphong.studio.histogram import Histogram as Histogram
    from pvphong.studio.probing import Probe as Probe
    from pvphong.vtk.lights import as_light as as_light
    from pvphong.vtk.lights import light_kit as light_kit
    from pvphong.vtk.oracle import vtk_shade as vtk_shade


def _vtk_lights() -> "Any":
    from pvphong.vtk import lights

    return lights


_host.answered_by(_vtk_lights)

_PLACES = {
    "accessor": "BlocksPhong MeshPhong",
    "base.color": "kelvin",
    "base.display": "Display",
    "batch.daylight": "daylight_files",
    "batch.run": "Batch",
    "batch.shading": "shade_files",
    "chunks": "evaluate",
    "filter": "PhongFilter",
    "geometry.transform": "SingularMatrixWarning",
    "meshes.daylight": "Daylight",
    "meshes.default_scene": "default_scene",
    "meshes.files": "read",
    "meshes.glance": "NormalsWarning",
    "meshes.lit": "plan",
    "meshes.stages": "stage",
    "meshes.truth": "Truth",
    "optics.colormap": "Colormap",
    "optics.lights": "DirectionalLight DiskLight EnvironmentLight Light PhotometricLight PointLight PolygonLight "
    "RectangleLight SphereLight SpotLight",
    "optics.material": "Material",
    "optics.reflectances": "GGX PBR BlinnPhong Metal ModifiedPhong OrenNayar Phong Retro Ward",
    "plotter": "PlotterPhong",
    "rays.transport": "Transport",
    "rays.visibility": "Visibility",
    "report": "Report",
    "scene.daylight": "daylight_scene",
    "scene.light_model": "LightModel",
    "scene.presets": "setups three_point",
    "scene.scene": "Scene load_materials",
    "scene.sun": "Place sun_position",
    "scene.viewer": "Viewer",
    "shading.plan.plan": "Plan",
    "shading.reference": "Shading",
    "studies.accuracy.measure": "tradeoff",
    "studies.accuracy.report": "Tradeoff",
    "studies.diagnose.diagnosis": "Diagnosis diagnose",
    "studies.fitting.image": "colors_from_image",
    "studies.fitting.result": "Fit",
    "studies.fitting.target": "target",
    "studies.validate.validation": "Comparison validate",
    "studio.histogram": "Histogram",
    "studio.probing": "Probe",
    "vtk.lights": "as_light light_kit",
    "vtk.oracle": "vtk_shade",
}
_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names.split()}
__all__ = sorted([*_PLACE_OF, "pipeline"])


def __getattr__(name: str) -> "Any":
    if name not in __all__:
        raise AttributeError(f"module 'pvphong' has no attribute {name!r}")
    from importlib import import_module

    if name == "pipeline":  # importing a submodule sets the attribute
        return import_module("pvphong.pipeline")
    value = globals()[name] = getattr(import_module(f"pvphong.{_PLACE_OF[name]}"), name)
    return value


def __dir__() -> list[str]:
    return __all__
