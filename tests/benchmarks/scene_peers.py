"""Other programs that light the vertices of a scene, for bench_transport.py and bench_peers.py.

Each takes a `Job` and prepares what does not depend on the number of rays; what it gives sends so many rays to every
vertex, and says how long that took, by the processor time of all threads. Surfaces are Lambert's, or rough mirrors
of GGX that reflect all light.
"""

import math
from dataclasses import dataclass

import numpy as np
import pyvista as pv

import pvphong as ph

try:
    from benchmarks.common import THREADS, Caster, baked, by_parts
except ImportError:
    from common import THREADS, Caster, baked, by_parts

PATHS_AT_ONCE = 2**22  # by Mitsuba
ALL_BOUNCES = 64


@dataclass(frozen=True)
class Job:
    """Blocks of triangles with normals, to be lit with `light_model.bounces`.

    Occluders are what a lamp is made of where other programs' lamps block light.
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
        """Shape (n, 3): points moved a little into a face, for rays that hit a corner slip through between faces."""
        return np.concatenate([_inward(block) for block in self.blocks])

    @property
    def normals(self) -> np.ndarray:
        return np.concatenate([block.point_data.active_normals for block in self.blocks])

    @property
    def views(self) -> np.ndarray:
        """Shape (n, 3): unit directions from which surfaces are seen."""
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
    """What sends the light that a light of ours sends; lamps with a size are black to what falls on them."""
    import mitsuba as mi

    if isinstance(light, ph.EnvironmentLight):
        ahead, right, up = light.axes
        turn = np.eye(4)
        turn[:3, :3] = np.stack([-right, up, ahead], axis=1)
        texels = light.image.image.repeat(8, axis=0).repeat(8, axis=1).astype(np.float32)  # it blends between texels
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


def mitsuba(job: Job) -> Caster:
    """Its `path` integrator, in LLVM mode, by rays that meet the surface at the vertices."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(THREADS)
    parts = {f"light {number}": _emitter(light) for number, light in enumerate(job.scene.lights)}
    for name, block in zip(job.blocks.keys(), job.blocks, strict=True):
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(_bsdf(job.materials[name]))
        shape = mi.Mesh(name, block.n_points, block.n_cells, has_vertex_normals=True, props=properties)
        parameters = mi.traverse(shape)
        parameters["vertex_positions"] = np.ravel(block.points).astype(np.float32)
        parameters["vertex_normals"] = np.ravel(block.point_data.active_normals).astype(np.float32)
        parameters["faces"] = block.regular_faces.astype(np.uint32).ravel()
        parameters.update()
        parts[name] = shape
    whole = mi.load_dict({"type": "scene"} | parts)
    depth = -1 if job.bounces >= ALL_BOUNCES else job.bounces + 2
    integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 5})
    begins, backward = (job.places + 1e-3 * job.views).astype(np.float32), -job.views.astype(np.float32)

    def of_some(rays: int, first: int, last: int) -> np.ndarray:
        count = (last - first) * rays
        sampler = mi.load_dict({"type": "independent", "sample_count": rays})
        sampler.seed(rays + first, count)
        row = dr.arange(mi.UInt32, count) // rays
        p = dr.gather(mi.Point3f, mi.Point3f(begins[first:last].T), row)
        d = dr.gather(mi.Vector3f, mi.Vector3f(backward[first:last].T), row)
        found, _, _ = integrator.sample(whole, sampler, mi.RayDifferential3f(mi.Ray3f(p, d)))
        return np.stack([np.array(dr.block_sum(channel, rays)) / rays for channel in found], axis=1)

    return by_parts(PATHS_AT_ONCE, job.count, of_some)


# --- Blender

_BAKE = """
import sys, time
import bpy, numpy as np
data, rays, threads = np.load(sys.argv[1]), int(sys.argv[3]), int(sys.argv[4])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine, scene.render.threads_mode, scene.render.threads = "CYCLES", "FIXED", threads
scene.cycles.device, scene.cycles.use_adaptive_sampling = "CPU", False
scene.cycles.max_bounces = scene.cycles.diffuse_bounces = int(data["bounces"])
for place, radius, power in zip(data["places"], data["radii"], data["powers"]):
    light = bpy.data.lights.new("light", "POINT")
    light.shadow_soft_size, light.use_soft_falloff, light.energy = float(radius), False, 4 * np.pi**2 * float(power)
    lamp = bpy.data.objects.new("lamp", light)
    lamp.location = place.tolist()
    scene.collection.objects.link(lamp)
things = []
for number in range(int(data["count"])):
    mesh = bpy.data.meshes.new(str(number))
    mesh.from_pydata(data[f"points{number}"].tolist(), [], data[f"corners{number}"].tolist())
    mesh.shade_smooth()
    material = bpy.data.materials.new(str(number))
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (*data["colors"][number].tolist(), 1.0)
    material.node_tree.links.new(diffuse.outputs[0], out.inputs[0])
    mesh.materials.append(material)
    mesh.color_attributes.new("seen", "FLOAT_COLOR", "POINT")
    mesh.color_attributes.active_color_index = 0
    thing = bpy.data.objects.new(str(number), mesh)
    scene.collection.objects.link(thing)
    thing.select_set(True)
    things.append(thing)
bpy.context.view_layer.objects.active = things[0]
kinds = {"DIRECT", "COLOR"} | ({"INDIRECT"} if data["bounces"] else set())
taken = []
for scene.cycles.samples, scene.cycles.seed in ((1, 0), (rays, rays)):
    start = time.process_time()
    bpy.ops.object.bake(target="VERTEX_COLORS", type="DIFFUSE", pass_filter=kinds)
    taken.append(time.process_time() - start)
seen = []
for thing in things:
    part = np.zeros((len(thing.data.vertices), 4), np.float32)
    thing.data.color_attributes["seen"].data.foreach_get("color", part.ravel())
    seen.append(part[:, :3])
seconds = (taken[1] - taken[0]) * rays / (rays - 1) if rays > 1 else taken[1]
np.savez(sys.argv[2], seen=np.concatenate(seen), seconds=seconds)
"""


def blender(job: Job, python: str | None) -> Caster:
    """Its bake of vertex colours by Cycles, in a process of its own; what it takes beside its rays does not count."""
    lights, materials = job.scene.lights, [job.materials[name] for name in job.blocks.keys()]  # noqa: SIM118
    if not all(hasattr(light, "position") for light in lights) or any(each.reflectance for each in materials):
        raise NotImplementedError("bakes no mirrors and no skies here")
    data = {f"points{number}": np.array(block.points) for number, block in enumerate(job.blocks)}
    data |= {f"corners{number}": np.array(block.regular_faces) for number, block in enumerate(job.blocks)}
    data |= {"colors": np.array([np.broadcast_to(each.diffuse, 3) for each in materials]), "count": len(materials)}
    data |= {"places": np.array([light.position for light in lights]), "bounces": job.bounces}
    data |= {"radii": np.array([getattr(light, "radius", 0.0) for light in lights])}
    data |= {"powers": np.array([light.intensity for light in lights])}
    return baked(_BAKE, python, data)
