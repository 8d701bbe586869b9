"""VTK's light kit, as lights."""

from __future__ import annotations

from dataclasses import replace

from vtkmodules.vtkRenderingCore import vtkLightKit, vtkRenderer

from pvphong.optics.light import Light
from pvphong.vtk.lights import from_vtk

_NAMES = ("head", "key", "fill", "back left", "back right")


def light_kit() -> tuple[Light, ...]:
    """The five lights of VTK's light kit, PyVista's default: they ride along with the camera.

    Source: vtkLightKit, whose own defaults these are; Halle and Meng, "LightKit: a lighting system for
    effective visualization" (2003).

    Returns
    -------
    tuple of Light
        "head", a headlight, and "key", "fill", "back left" and "back right" in the camera's frame.
    """
    kit, renderer = vtkLightKit(), vtkRenderer()
    kit.AddLightsToRenderer(renderer)
    kit.Update()
    lights = [from_vtk(light, 1.0) for light in renderer.GetLights()]
    return tuple(replace(light, name=name) for light, name in zip(lights, _NAMES, strict=True))
