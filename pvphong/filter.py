"""`ph.PhongFilter`: lighting as a filter in a VTK pipeline."""

from __future__ import annotations

from inspect import signature
from typing import Any, ClassVar

import pyvista as pv
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkOutputWindow

from pvphong.base import check
from pvphong.base.handles import Handle
from pvphong.meshes.lit import shade_mesh
from pvphong.optics.material import Material, as_material
from pvphong.scene.scene import Scene, SceneLike, as_scene


class PhongFilter(Handle, VTKPythonAlgorithmBase):  # type: ignore[misc]  # VTK's class has no type
    """VTK filter that adds lit colours to polydata, by default as the point array "phong", (n_points, 3) float32.

    It executes again only if its input, scene, material or options have changed.

    Examples
    --------
    >>> import vtk, pvphong as ph
    >>> source = vtk.vtkSphereSource()
    >>> phong = ph.PhongFilter()
    >>> phong.SetInputConnection(source.GetOutputPort())
    >>> phong.SetScene(ph.Scene(lights=[ph.DirectionalLight()]))
    >>> phong.Update()
    >>> phong.GetOutput().GetPointData().GetArray("phong").GetNumberOfComponents()
    3
    """

    InputType: str
    OutputType: str
    _instead: ClassVar = {"scene": "SetScene", "material": "SetMaterial", "options": "SetOptions"}

    def __init__(self) -> None:
        super().__init__(nInputPorts=1, inputType="vtkPolyData", nOutputPorts=1, outputType="vtkPolyData")
        self._scene = Scene()
        self._material = Material()
        self._options: dict[str, Any] = {}
        self._refusal: ValueError | None = None

    def __repr__(self) -> str:
        return f"<PhongFilter: {len(tuple(self._scene.lights))} lights, {self._material}>"

    def SetScene(self, scene: SceneLike) -> None:
        """Set lights, viewer and light model. Setting an equal scene does not execute the filter again."""
        scene = as_scene(scene)
        if scene != self._scene:
            self._scene = scene
            self.Modified()

    def GetScene(self) -> Scene:
        """Return the scene; initially without lights."""
        return self._scene

    def SetMaterial(self, material: Material | str) -> None:
        """Set the surface's material. Setting an equal material does not execute the filter again."""
        material = as_material(material)
        if material != self._material:
            self._material = material
            self.Modified()

    def SetOptions(self, **options: Any) -> None:
        """Set options of `mesh.phong.shade`, such as matrix, feature_angle, components or backend.

        These options replace all earlier ones.

        Raises
        ------
        ValueError
            If an option does not exist.
        """
        known = [name for name, each in signature(shade_mesh).parameters.items() if each.kind is each.KEYWORD_ONLY]
        for name in options:
            check.choice("option", name, known)
        self._options = options
        self.Modified()

    def GetMaterial(self) -> Material:
        """Return the material; initially OpenGL's default."""
        return self._material

    def SetInputData(self, data: Any) -> None:
        """Set a vtkPolyData as the input, without an upstream filter."""
        self.SetInputDataObject(0, data)

    def GetOutput(self) -> Any:
        """Return the lit vtkPolyData."""
        return self.GetOutputDataObject(0)

    def RequestData(self, _request: Any, inputs: Any, outputs: Any) -> int:
        """Compute the output; the pipeline calls this when the output is out of date."""
        source, self._refusal = pv.wrap(self.GetInputData(inputs, 0, 0)), None
        try:
            # An upstream filter may output an empty mesh, which is not an error in a pipeline.
            lit = shade_mesh(source, self._scene, self._material, **self._options) if source.n_points else source
        except ValueError as error:
            self._refusal = error
            vtkOutputWindow.GetInstance().DisplayErrorText(f"PhongFilter: {error}\n")
            return 0
        self.GetOutputData(outputs, 0).ShallowCopy(lit)
        return 1

    def Update(self) -> None:
        """Bring the output up to date.

        Raises
        ------
        ValueError
            If the input cannot be lit. A downstream filter gets VTK's error message instead.
        """
        super().Update()  # does not execute if nothing has changed; then the last error is raised again
        if self._refusal is not None:
            raise self._refusal
