"""Lighting as data for PyVista and VTK.

`import pvphong as ph` gives the names below; `mesh.phong` and `plotter.phong` are there in PyVista even without it.
"""

from pvphong.evaluation import evaluate
from pvphong.lights import DirectionalLight, PointLight, SpotLight, as_light, light_from_homogeneous
from pvphong.material import Material
from pvphong.scene import LightModel, Scene
from pvphong.shading import Shading
from pvphong.transform import normal_matrix, transform_normals, transform_points, transform_vectors
from pvphong.viewer import Viewer

__all__ = [
    "DirectionalLight",
    "LightModel",
    "Material",
    "PointLight",
    "Scene",
    "Shading",
    "SpotLight",
    "Viewer",
    "as_light",
    "evaluate",
    "light_from_homogeneous",
    "normal_matrix",
    "transform_normals",
    "transform_points",
    "transform_vectors",
]
