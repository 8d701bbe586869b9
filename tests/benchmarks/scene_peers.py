"""Other programs that light the vertices of a scene, for bench_transport.py and bench_peers.py.

Each function takes a `Job`, prepares what does not depend on the number of rays, and returns a caster. This sends a
number of rays to every vertex and measures the processor time of all threads. Surfaces are Lambertian, or rough GGX
mirrors that reflect all light.
"""

import math
from dataclasses import dataclass

import numpy as np
import pyvista as pv
from common import THREADS, Caster, baked, by_parts

import pvphong as ph

PATHS_AT_ONCE = 2**22  # by Mitsuba
ALL_BOUNCES = 64


@dataclass(frozen=True)
class Job:
    """Blocks of triangles with normals, to light with `light_model.bounces`.

    Occluders are the bodies of lamps, because lamps of other programs block light.
    """

    blocks: pv.MultiBlock
    scene: ph.Scene
    materials: dict[str, ph.Material]
    occluders: tuple[pv.PolyData, ...] = ()

    @property
    def bounces(self) -> int:
        return self.scene.light_model.bounces

    @property
    def count(self) -> int:
        return sum(block.n_points for block in self.blocks)

    @property
    def places(self) -> np.ndarray:
        """Points moved slightly into a face, shape (n, 3), because rays at a corner may pass between faces."""
        return np.concatenate([_inward(block) for block in self.blocks])

    @property
    def normals(self) -> np.ndarray:
        return np.concatenate([block.point_data.active_normals for block in self.blocks])

    @property
    def views(self) -> np.ndarray:
        """Unit directions from which surfaces are seen, shape (n, 3)."""
        if not any(material.reflectance for material in self.materials.values()):
            return self.normals
        to_eye = np.asarray(self.scene.viewer.position) - self.places
        return to_eye / np.linalg.norm(to_eye, axis=1)[:, None]


def _inward(block: pv.PolyData) -> np.ndarray:
    moved, corners = np.array(block.points, np.float64), block.regular_faces
    middles = block.points[corners].mean(axis=1)
    for corner in corners.T:
        moved[corner] = block.points[corner] + 1e-3 * (middles - block.points[corner])
    return moved


# --- Mitsuba 3


def _rgb(value) -> dict:
    return {"type": "rgb", "value": np.broadcast_to(np.asarray(value, float), 3).tolist()}


def _emitter(light: ph.Light) -> dict:
    """Return the emitter that corresponds to a light; area lights reflect no light."""
    import mitsuba as mi

    if isinstance(light, ph.EnvironmentLight):
        ahead, right, up = light.axes
        turn = np.eye(4)
        turn[:3, :3] = np.stack([-right, up, ahead], axis=1)
        texels = light.image.image.repeat(8, axis=0).repeat(8, axis=1).astype(np.float32)  # it interpolates texels
        return {"type": "envmap", "bitmap": mi.Bitmap(texels), "to_world": mi.ScalarTransform4f(turn)}
    place = list(light.position)
    if isinstance(light, ph.SphereLight):
        glow = {"type": "area", "radiance": _rgb(light.intensity / light.radius**2)}
        black = {"type": "diffuse", "reflectance": _rgb(0.0)}
        return {"type": "sphere", "center": place, "radius": light.radius, "emitter": glow, "bsdf": black}
    return {"type": "point", "position": place, "intensity": _rgb(math.pi * light.intensity)}


def _bsdf(material: ph.Material) -> dict:
    if material.reflectance is None:
        return {"type": "diffuse", "reflectance": _rgb(material.diffuse)}
    return {
        "type": "roughconductor",
        "material": "none",
        "distribution": "ggx",
        "alpha": material.reflectance.roughness**2,
    }


def mesh_of_mitsuba(points: np.ndarray, corners: np.ndarray, bsdf: dict, normals: np.ndarray | None = None):
    import mitsuba as mi

    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    has_normals = normals is not None
    shape = mi.Mesh("triangles", len(points), len(corners), has_vertex_normals=has_normals, props=properties)
    parameters = mi.traverse(shape)
    parameters["vertex_positions"] = np.ravel(points).astype(np.float32)
    if has_normals:
        parameters["vertex_normals"] = np.ravel(normals).astype(np.float32)
    parameters["faces"] = np.ravel(corners).astype(np.uint32)
    parameters.update()
    return shape


def returning(scene, integrator, sampler: dict, begins: np.ndarray, directions: np.ndarray):
    """Return a function for `by_parts` that returns the channels of the radiance along rays of some vertices."""
    import drjit as dr
    import mitsuba as mi

    origins, directions = mi.Point3f(np.float32(begins.T)), mi.Vector3f(np.float32(directions.T))

    def of_some(rays: int, first: int, last: int) -> np.ndarray:
        count = (last - first) * rays
        random = mi.load_dict(sampler | {"sample_count": rays})
        random.seed(dr.opaque(mi.UInt32, rays + first), count)
        row = dr.arange(mi.UInt32, count) // rays + dr.opaque(mi.UInt32, first)
        ray = mi.Ray3f(dr.gather(mi.Point3f, origins, row), dr.gather(mi.Vector3f, directions, row))
        found, _, _ = integrator.sample(scene, random, mi.RayDifferential3f(ray))
        return np.stack([np.array(dr.block_sum(channel, rays)) / rays for channel in found], axis=1)

    return of_some


def mitsuba(job: Job) -> Caster:
    """Return a caster of its `path` integrator, in LLVM mode, along rays that hit the surface at the vertices."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(THREADS)
    parts = {f"light {number}": _emitter(light) for number, light in enumerate(job.scene.lights)}
    for name, block in zip(job.blocks.keys(), job.blocks, strict=True):
        normals = block.point_data.active_normals
        parts[name] = mesh_of_mitsuba(block.points, block.regular_faces, _bsdf(job.materials[name]), normals)
    whole = mi.load_dict({"type": "scene"} | parts)
    depth = -1 if job.bounces >= ALL_BOUNCES else job.bounces + 2
    integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 5})
    begins = job.places + 1e-3 * job.views
    back = returning(whole, integrator, {"type": "independent"}, begins, -job.views)
    return by_parts(PATHS_AT_ONCE, job.count, back)


# --- Blender


def blender(job: Job, python: str | None) -> Caster:
    lights, materials = job.scene.lights, [job.materials[name] for name in job.blocks.keys()]  # noqa: SIM118
    if not all(hasattr(light, "position") for light in lights) or any(each.reflectance for each in materials):
        raise NotImplementedError("cannot bake mirrors and skies in this benchmark")
    lamps = {"places": [light.position for light in lights], "powers": [light.intensity for light in lights]}
    lamps["radii"] = [getattr(light, "radius", 0.0) for light in lights]
    colors = [np.broadcast_to(each.diffuse, 3) for each in materials]
    return baked(python, list(job.blocks), len(materials), colors=colors, bounces=job.bounces, **lamps)
