"""glTF 2.0 files of lit meshes, or of meshes with lights.

Lit colours are marked by the extension KHR_materials_unlit, so other programs show them unchanged. Lights are written
with the extension KHR_lights_punctual. The colours are then unlit, and the program that opens the file lights the mesh.
Source: Khronos, "glTF 2.0 Specification".
"""

from __future__ import annotations

import base64
import json
import math
import struct
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from pvphong.base import check
from pvphong.base.types import FloatArray, rgb
from pvphong.meshes.surfaces import has_faces, point_normals, polygons
from pvphong.optics.light import Light
from pvphong.optics.lights import nearest_in_vtk, vtk_values
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene

_FLOAT, _SHORT, _INT = 5126, 5123, 5125  # OpenGL's constants for types of numbers
_VERTICES, _INDICES = 34962, 34963  # OpenGL's constants for targets of buffers
_FULL = 65535.0
_ALL_AROUND = math.pi
"""Illuminance in lux that gives a white Lambertian surface a luminance of 1."""

_Z_UP = (-math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Rotation, as a quaternion (x, y, z, w), from coordinates with z up to glTF's coordinates with y up."""


class LightsWarning(UserWarning):
    """Warning about lights that a file format cannot represent."""


class Part(NamedTuple):
    """A mesh to write, with its name, and with its linear colours from 0 to 1, shape (n, 3)."""

    name: str
    mesh: pv.PolyData
    colors: FloatArray


def write(path: Path, parts: Sequence[Part], scene: Scene | None = None, materials: Sequence[Material] = ()) -> None:
    """Write meshes with vertex colours, as text for .gltf and as binary data for .glb.

    Positions are float32, relative to the centre of each mesh; the centre is the translation of the mesh's node. So a
    mesh far from the origin keeps its precision. The root node rotates the scene, because glTF's up axis is y.

    Parameters
    ----------
    path : Path
        A path with suffix .gltf or .glb.
    parts : sequence of Part
        The meshes; their faces are triangulated.
    scene : Scene, optional
        Scene whose lights are written too. The vertex colours must then be unlit, because the program that opens
        the file lights them.
    materials : sequence of Material, optional
        Material of each part, for its highlights; required with `scene`.

    Raises
    ------
    ValueError
        If a mesh has no faces.

    Warns
    -----
    LightsWarning
        If glTF cannot represent a light.
    """
    file = _File()
    nodes = [file.part(part, materials[k] if scene is not None else None) for k, part in enumerate(parts)]
    if scene is not None:
        nodes += file.lights(scene)
    file.write(path, nodes)


class _File:
    """The JSON objects and the binary data of a glTF file, collected before it is written."""

    def __init__(self) -> None:
        self.bytes = bytearray()
        self.lists: dict[str, list[Any]] = {}
        self.extensions: dict[str, Any] = {}
        self.used: set[str] = set()

    def add(self, kind: str, what: dict[str, Any]) -> int:
        """Append the JSON object `what` to one of the file's lists, and return its index there.

        `kind` is the name of the list, such as "nodes".
        """
        self.lists.setdefault(kind, []).append(what)
        return len(self.lists[kind]) - 1

    def array(self, rows: NDArray[Any], kind: int, shape: str, target: int, **more: Any) -> int:
        """Append an array to the binary data; return the index of its accessor, the object that describes it in glTF.

        Parameters
        ----------
        rows : ndarray
            The array.
        kind : int
            OpenGL's constant for the type of its numbers, such as 5126 for float32.
        shape : str
            glTF's name for the shape of a row, such as "VEC3".
        target : int
            OpenGL's constant for the buffer: vertices or indices.
        **more
            Further entries of the accessor's JSON object.
        """
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        data = np.ascontiguousarray(rows).tobytes()
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(data), "target": target}
        self.bytes += data
        view_at = self.add("bufferViews", view)
        count = {"bufferView": view_at, "componentType": kind, "count": len(rows), "type": shape}
        return self.add("accessors", count | more)

    def part(self, part: Part, material: Material | None) -> int:
        """Append a mesh, and return the index of its node.

        With a material, the program that opens the file lights the mesh; with None, it shows the colours unlit.
        """
        mesh = part.mesh
        if not has_faces(mesh):
            check.refuse(
                "mesh", f"{mesh.n_points} points and no faces", "a mesh with faces, to be written as .gltf or .glb"
            )
        points = np.asarray(mesh.points, np.float64)
        used = np.asarray(np.isfinite(points).all(axis=1))
        middle = 0.5 * (points[used].min(axis=0) + points[used].max(axis=0)) if used.any() else np.zeros(3)
        positions = np.where(used[:, None], points - middle, 0.0).astype(np.float32)
        normals = np.array(point_normals(mesh), np.float32)
        lengths = np.linalg.norm(normals, axis=1)
        is_unit = np.isfinite(lengths) & (lengths > 0.0)
        normals = np.where(is_unit[:, None], normals / np.where(is_unit, lengths, 1.0)[:, None], (0.0, 0.0, 1.0))
        colors = np.full((len(points), 4), _FULL)
        colors[:, :3] = np.rint(_FULL * np.clip(np.nan_to_num(part.colors), 0.0, 1.0))
        corners = np.asarray(_triangles(mesh, used), np.uint32)
        limits = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
        attributes = {
            "POSITION": self.array(positions, _FLOAT, "VEC3", _VERTICES, **limits),
            "NORMAL": self.array(normals.astype(np.float32), _FLOAT, "VEC3", _VERTICES),
            "COLOR_0": self.array(colors.astype(np.uint16), _SHORT, "VEC4", _VERTICES, normalized=True),
        }
        primitive = {
            "attributes": attributes,
            "indices": self.array(corners.ravel(), _INT, "SCALAR", _INDICES),
            "material": self.add("materials", self._material(material)),
        }
        own = {"name": part.name} if part.name else {}
        at = self.add("meshes", own | {"primitives": [primitive]})
        return self.add("nodes", own | {"mesh": at, "translation": middle.tolist()})

    def _material(self, material: Material | None) -> dict[str, Any]:
        shared: dict[str, Any] = {"doubleSided": True}
        if material is None:
            self.used.add("KHR_materials_unlit")
            plain = {"baseColorFactor": [1.0, 1.0, 1.0, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}
            return shared | {"pbrMetallicRoughness": plain, "extensions": {"KHR_materials_unlit": {}}}
        reflectance, shininess = material.reflectance, material.shininess
        roughness = getattr(reflectance, "roughness", None)
        if not isinstance(roughness, float):  # from Blinn-Phong's width: α² = 2 / (n + 2), with α = roughness²
            roughness = (2.0 / (shininess + 2.0)) ** 0.25 if isinstance(shininess, float) else 0.5
            shows = "specular" in material.maps or any(rgb(material.specular))
            roughness = roughness if shows else 1.0
        metallic = getattr(reflectance, "metallic", 0.0)
        numbers = {"metallicFactor": metallic if isinstance(metallic, float) else 0.0, "roughnessFactor": roughness}
        return shared | {"pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 1.0, 1.0]} | numbers}

    def lights(self, scene: Scene) -> list[int]:
        """Append those lights of a scene that glTF can represent, and return the indices of their nodes.

        A `LightsWarning` names the lights that glTF cannot represent.
        """
        nodes, lights, left_out = list[int](), list[dict[str, Any]](), list[str]()
        for light in scene.world_lights:
            if not light.on:
                continue
            found = _punctual(light)
            if found is None:
                left_out.append(f"{light.name or type(light).__name__}")
                continue
            as_written, place = found
            nodes.append(self.add("nodes", place | {"extensions": {"KHR_lights_punctual": {"light": len(lights)}}}))
            lights.append(as_written)
        if lights:
            self.used.add("KHR_lights_punctual")
            self.extensions["KHR_lights_punctual"] = {"lights": lights}
        if left_out:
            allowed = "directional lights, and point and spot lights with inverse-square attenuation"
            text = f"{', '.join(left_out)} cannot be stored in glTF, which has only {allowed}."
            warnings.warn(text, LightsWarning, stacklevel=4)
        return nodes

    def write(self, path: Path, nodes: list[int]) -> None:
        """Write the file. `nodes` are the indices of the nodes to show.

        They become children of a root node, which rotates the z axis to glTF's up axis, y.
        """
        root = self.add("nodes", {"name": "z up", "rotation": _Z_UP, "children": nodes})
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        buffer: dict[str, Any] = {"byteLength": len(self.bytes)}
        is_text = path.suffix.lower() == ".gltf"
        if is_text:
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.bytes).decode()
        found: dict[str, Any] = {"asset": {"version": "2.0", "generator": "pvphong"}, "scene": 0}
        found |= {"scenes": [{"nodes": [root]}], "buffers": [buffer]} | self.lists
        found |= {"extensionsUsed": sorted(self.used)} if self.used else {}
        found |= {"extensions": self.extensions} if self.extensions else {}
        text = json.dumps(found, separators=(",", ":")).encode()
        if is_text:
            path.write_bytes(text)
            return
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(self.bytes), 0x004E4942) + self.bytes
        path.write_bytes(struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks)


def _triangles(mesh: pv.PolyData, is_finite: NDArray[Any]) -> NDArray[Any]:
    """Return a mesh's faces as triangles, shape (m, 3). Triangles with a point that is not finite are left out.

    `is_finite` is the mask of the finite points.
    """
    if not (mesh.is_all_triangles and not mesh.n_strips):
        bare = pv.PolyData()
        bare.points = np.asarray(mesh.points)
        connectivity, offsets = polygons(mesh)
        bare.faces = pv.CellArray.from_arrays(offsets, connectivity)
        mesh = bare.triangulate(inplace=False)
    corners = np.asarray(mesh.regular_faces)
    return corners[is_finite[corners].all(axis=1)]


def _punctual(light: Light) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """Return a light as a JSON object of KHR_lights_punctual, and the translation and rotation of the light's node.

    The result is None if glTF has no such light.
    """
    if light.has_size or nearest_in_vtk(light) is not light:
        return None
    values = vtk_values(light)
    color = [light.intensity * channel for channel in rgb(light.diffuse)]
    most = max(color)
    found: dict[str, Any] = {"color": [each / most if most else 0.0 for each in color], "intensity": _ALL_AROUND * most}
    found |= {"name": light.name} if light.name else {}
    turned = {"rotation": _turned(values.direction)}
    if not values.is_positional:
        return found | {"type": "directional"}, turned
    constant, linear, quadratic = values.attenuation
    if constant or linear:
        return None
    found["intensity"] /= quadratic
    place = {"translation": list(values.position)}
    if values.cone_angle is None and not values.exponent:
        return found | {"type": "point"}, place
    edge = math.radians(min(values.cone_angle or 90.0, 90.0))
    cone = {"innerConeAngle": 0.0 if values.exponent else max(edge - 1e-4, 0.0), "outerConeAngle": edge}
    return found | {"type": "spot", "spot": cone}, place | turned


def _turned(direction: Any) -> list[float]:
    """Return the rotation from the direction −z to the direction `direction`, as a quaternion (x, y, z, w)."""
    d = np.array(direction, np.float64)
    x, y, z = d / np.linalg.norm(d)
    if z > 1.0 - 1e-12:
        return [1.0, 0.0, 0.0, 0.0]
    quaternion = np.array([y, -x, 0.0, 1.0 - z])  # (−z) × d, 1 + (−z) · d
    return list((quaternion / np.linalg.norm(quaternion)).tolist())
