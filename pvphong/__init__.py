"""Lighting as data for PyVista and VTK."""

from pvphong.lights import DirectionalLight, PointLight, SpotLight, as_light, light_from_homogeneous
from pvphong.material import Material
from pvphong.scene import LightModel, Scene
from pvphong.viewer import Viewer
