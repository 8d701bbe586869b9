"""Visibility of a sphere light or of the sky by other programs, for bench_visibility.py.

Each function takes a `Job`, prepares what does not depend on the number of rays, and returns a caster, which casts a
number of rays from every vertex and measures the time. Two compute something else, and are compared with their own
truth: Blender casts from every corner of every face, slightly inside it, and libigl weights directions uniformly
instead of by the cosine.
"""

import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import pyvista as pv
from common import THREADS, Cast, Caster, baked, by_parts, timed
from scene_peers import mesh_of_mitsuba, returning

import pvphong as ph

ABOVE = 1e-4
"""Height above the surface at which plain rays start; meshes are some six units wide."""
RAYS_AT_ONCE = 2**25  # by Mitsuba
FAR = 1e6


@dataclass(frozen=True)
class Job:
    """Visibility of a light, or of the sky if it is None, from the vertices of a triangle mesh with normals.

    The mesh and the occluders block rays.
    """

    mesh: pv.PolyData
    occluders: tuple[pv.PolyData, ...] = ()
    light: ph.SphereLight | None = None

    @property
    def scene(self) -> ph.Scene:
        return ph.Scene([self.light] if self.light else [], light_model=ph.LightModel(ambient=1.0))

    @cached_property
    def points(self) -> np.ndarray:
        return np.array(self.mesh.points, np.float32)

    @cached_property
    def normals(self) -> np.ndarray:
        return np.array(self.mesh.point_data.active_normals, np.float32)

    @cached_property
    def triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Points, float32, and corners of all triangles that block rays."""
        whole = pv.merge([self.mesh, *self.occluders], merge_points=False) if self.occluders else self.mesh
        return np.array(whole.points, np.float32), np.array(whole.regular_faces, np.int64)

    def some(self, step: int) -> "Job":
        """Return the job with rays from every `step`-th vertex only, and the same occluders."""
        few = pv.PolyData(self.mesh.points[::step])
        few.point_data.active_normals = self.mesh.point_data.active_normals[::step]
        return Job(few, (self.mesh, *self.occluders), self.light)


# --- plain random rays, by embreex's own `run`


def _scene_of_embreex(points: np.ndarray, corners: np.ndarray):
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, points, corners.astype(np.int32))
    one = np.ones((1, 3), np.float32)
    scene.run(one, one, dists=one[:, 0], query="OCCLUDED")  # the first ray builds the tree
    return scene


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def _random_ray(job: Job, points: np.ndarray, normals: np.ndarray, random: np.random.Generator):
    """Return a direction, a length and the weight of the arriving light for each vertex."""
    ball = _unit(random.standard_normal(points.shape, np.float32))
    if job.light is None:  # cosine-weighted
        return _unit(normals + ball), np.full(len(points), FAR, np.float32), np.ones(len(points), np.float32)
    to_light = np.float32(job.light.position) - points  # uniform in the cone that the sphere subtends
    distance = np.linalg.norm(to_light, axis=1)
    axis = to_light / distance[:, None]
    least = np.sqrt(1.0 - (job.light.radius / distance) ** 2)
    cosine = 1.0 - random.random(len(points), np.float32) * (1.0 - least)
    across = _unit(ball - (ball * axis).sum(axis=1)[:, None] * axis)
    directions = cosine[:, None] * axis + np.sqrt(1.0 - cosine**2)[:, None] * across
    return directions, distance - np.float32(job.light.radius), np.maximum((directions * normals).sum(axis=1), 0.0)


def plain_rays(job: Job) -> Caster:
    """Return a caster that generates rays in NumPy, one per vertex at a time, on two threads with half the vertices."""
    scene, begins = _scene_of_embreex(*job.triangles), job.points + np.float32(ABOVE) * job.normals

    def of_some(rays: int, some: slice) -> np.ndarray:
        random, points, normals = np.random.default_rng(some.start), job.points[some], job.normals[some]
        sent, seen = np.zeros(len(points)), np.zeros(len(points))
        for _ in range(rays):
            directions, lengths, weights = _random_ray(job, points, normals, random)
            is_free = scene.run(begins[some], directions, dists=lengths, query="OCCLUDED") < 0
            sent += weights
            seen += weights * is_free
        return seen / sent

    def work(rays: int) -> np.ndarray:
        ends = np.linspace(0, len(begins), THREADS + 1).astype(int).tolist()
        with ThreadPoolExecutor(THREADS) as pool:
            return np.concatenate(list(pool.map(partial(of_some, rays), map(slice, ends, ends[1:]))))

    return timed(work)


def embreex_alone(mesh: pv.PolyData, lights: list) -> float:
    """Return seconds of embreex's calls on one thread: its tree, and a ray to each light that a vertex faces."""
    points, normals = np.asarray(mesh.points, np.float32), np.asarray(mesh.point_data.active_normals, np.float32)
    start = time.perf_counter()
    scene = _scene_of_embreex(points, mesh.regular_faces)
    taken = time.perf_counter() - start
    for light in lights:
        direction = getattr(light, "direction", None)
        to_light = np.float32(light.position) - points if direction is None else np.float32([direction]) * -1
        to_light = np.broadcast_to(to_light, points.shape)
        is_facing = (to_light * normals).sum(axis=1) > 0.0
        begins, to_light = points[is_facing] + np.float32(1e-5) * normals[is_facing], to_light[is_facing]
        lengths = np.linalg.norm(to_light, axis=1) if direction is None else np.full(len(begins), FAR, np.float32)
        start = time.perf_counter()
        scene.run(begins, _unit(to_light), dists=lengths, query="OCCLUDED")
        taken += time.perf_counter() - start
    return taken


# --- Mitsuba 3


def _scene_of_mitsuba(job: Job):
    """Return the scene in LLVM mode, with white two-sided surfaces."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_mono")
    dr.set_thread_count(THREADS)
    white = {"type": "diffuse", "reflectance": {"type": "spectrum", "value": 1.0}}
    shape = mesh_of_mitsuba(*job.triangles, {"type": "twosided", "white": white})
    emitter = {"type": "constant"}
    if job.light:
        place, radius = list(job.light.position), job.light.radius
        emitter = {"type": "sphere", "center": place, "radius": radius, "emitter": {"type": "area"}}
    return mi.load_dict({"type": "scene", "triangles": shape, "emitter": emitter})


def mitsuba(job: Job) -> Caster:
    """Return a caster that works like its `direct` integrator: multijittered samples of the light or of a cosine.

    Two differences from the integrator make its error smaller: the sampler knows which samples belong to a vertex, and
    samples of the light are divided by the unoccluded samples.
    """
    import drjit as dr
    import mitsuba as mi

    scene = _scene_of_mitsuba(job)
    places, normals = mi.Point3f(job.points.T), mi.Normal3f(job.normals.T)

    def of_some(rays: int, first: int, last: int) -> np.ndarray:
        count = (last - first) * rays
        sampler = mi.load_dict({"type": "multijitter", "sample_count": rays})
        sampler.set_samples_per_wavefront(rays)
        sampler.seed(dr.opaque(mi.UInt32, first), count)
        row = dr.arange(mi.UInt32, count) // rays + dr.opaque(mi.UInt32, first)
        at = dr.zeros(mi.SurfaceInteraction3f, count)
        at.p, at.n = dr.gather(mi.Point3f, places, row), dr.gather(mi.Normal3f, normals, row)
        if job.light is None:
            direction = mi.Frame3f(at.n).to_world(mi.warp.square_to_cosine_hemisphere(sampler.next_2d()))
            is_free = ~scene.ray_test(at.spawn_ray(direction))
            return np.array(dr.block_sum(dr.select(is_free, mi.Float(1), 0), rays)) / rays
        chosen, weight = scene.sample_emitter_direction(at, sampler.next_2d(), False)
        sent = weight[0] * dr.maximum(dr.dot(at.n, chosen.d), 0)
        is_free = ~scene.ray_test(at.spawn_ray_to(chosen.p))
        seen, whole = dr.block_sum(dr.select(is_free, sent, 0), rays), dr.block_sum(sent, rays)
        return np.array(seen / whole)

    return by_parts(RAYS_AT_ONCE, len(job.points), of_some)


def mitsuba_as_it_comes(job: Job) -> Caster:
    """Return a caster that runs its `direct` integrator along rays that hit the surface at the vertices.

    It supports only lights. One multijittered sampler is seeded for all vertices. The arriving light is divided by the
    unoccluded light, with as many samples as the truth.
    """
    import mitsuba as mi

    if job.light is None:
        raise NotImplementedError("needs a point within a face, and hits a knot next to its vertices")
    scenes = [_scene_of_mitsuba(each) for each in (job, Job(job.mesh, (), job.light))]
    integrator = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
    inside = job.points + 1e-6 * (job.points.mean(axis=0) - job.points)  # rays to the border may miss it
    begins, sampler = inside + 1e-3 * job.normals, {"type": "multijitter"}
    seen, unblocked = (returning(scene, integrator, sampler, begins, -job.normals) for scene in scenes)
    _, whole = by_parts(RAYS_AT_ONCE, len(begins), unblocked)(4096)

    def of_some(rays: int, first: int, last: int) -> np.ndarray:
        return (seen(rays, first, last) / whole[first:last])[:, 0]

    return by_parts(RAYS_AT_ONCE, len(begins), of_some)


# --- libigl


def libigl(job: Job) -> Caster:
    """Return a caster of its ambient occlusion, whose directions are uniform."""
    from igl.embree import EmbreeIntersector, ambient_occlusion

    if job.light is not None:
        raise NotImplementedError("has no lights")
    (points, corners), looks = job.triangles, (job.points.astype(float), job.normals.astype(float))
    triangles = EmbreeIntersector()
    triangles.init(np.asfortranarray(points), np.asfortranarray(corners, np.int32))
    return timed(lambda rays: 1.0 - ambient_occlusion(triangles, *looks, rays))


# --- Blender


def blender(job: Job, *, python: str | None) -> Caster:
    """Return a caster that divides its light by the unoccluded light."""
    lights, unblocked = [job.light] if job.light else [], np.ones(len(job.points))
    for light in lights:
        to_light = np.array(light.position) - job.points
        unblocked = (to_light * job.normals).sum(axis=1) / np.linalg.norm(to_light, axis=1) ** 3
    lamps = {"places": [light.position for light in lights], "radii": [light.radius for light in lights]}
    lamps["powers"] = [1.0] * len(lights)
    bake = baked(python, [job.mesh, *job.occluders], 1, colors=np.ones((1, 3)), bounces=0, **lamps)

    def cast(rays: int) -> Cast:
        seconds, seen = bake(rays)
        return Cast(seconds, seen[:, 0] / unblocked)

    return cast
