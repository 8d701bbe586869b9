"""Light that bounces, beside Mitsuba 3's path integrator and Blender's bake: time against error at the same vertices.

    python tests/benchmarks/bench_transport.py [cells] [--blender PYTHON]

A closed room of grids with a coloured wall on either side, a plate in it, and a glowing ball. All bounces are
wanted at every vertex; the judge is `mesh.phong.truth` with many paths, whose noise is taken off each error. Times are
processor times of the whole call, rays included: for `transport` also the second time, by other lights. Mitsuba sends
paths to the vertices from just above; Blender bakes vertex colours in a process of its own, and its brightness is
scaled to the judge's.
"""

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pyvista as pv
from rich.console import Console

import pvphong as ph

try:
    from benchmarks.common import equal_error_seconds, slope, table
except ImportError:
    from common import equal_error_seconds, slope, table

THREADS = 2
OURS = "transport and all bounces"
JUDGE_PATHS, ALL_BOUNCES = 1024, 64
COLORS = {"floor": (0.7, 0.7, 0.7), "ceiling": (0.7, 0.7, 0.7), "back": (0.7, 0.7, 0.6), "front": (0.6, 0.6, 0.6)}
COLORS |= {"left": (0.7, 0.1, 0.1), "right": (0.1, 0.6, 0.1), "plate": (0.5, 0.5, 0.7)}


def grid(center, direction, cells, size=1.0):
    many = {"i_size": size, "j_size": size, "i_resolution": cells, "j_resolution": cells}
    mesh = pv.Plane(center=center, direction=direction, **many).triangulate()
    mesh.clear_data()
    mesh.point_data.active_normals = np.tile(np.float32(direction), (mesh.n_points, 1))
    return mesh


def room(cells):
    """Blocks by name."""
    slant = np.array([0.3, -0.8, 0.5]) / np.linalg.norm([0.3, -0.8, 0.5])
    return pv.MultiBlock(
        {
            "floor": grid((0, 0, -0.5), (0, 0, 1), cells),
            "ceiling": grid((0, 0, 0.5), (0, 0, -1), cells),
            "back": grid((0, 0.5, 0), (0, -1, 0), cells),
            "front": grid((0, -0.5, 0), (0, 1, 0), cells),
            "left": grid((-0.5, 0, 0), (1, 0, 0), cells),
            "right": grid((0.5, 0, 0), (-1, 0, 0), cells),
            "plate": grid((0.05, 0.1, -0.15), tuple(slant), max(cells // 3, 1), 0.4),
        }
    )


LAMP = ph.SphereLight(position=(0.1, -0.1, 0.25), radius=0.08, intensity=0.12, name="lamp")
BULB = pv.Icosphere(radius=0.998 * LAMP.radius, center=LAMP.position, nsub=4)
"""Mitsuba's and Blender's lamps block light."""
MATERIALS = {name: ph.Material(ambient=0.0, specular=0.0, diffuse=color) for name, color in COLORS.items()}


def scene(bounces):
    model = ph.LightModel(ambient=0.0, clamp=False, shadows=True, bounces=bounces)
    return ph.Scene([LAMP], ph.Viewer((0, -0.4, 0), (0, 0, 0), (0, 0, 1)), model)


def joined(by_block, value):
    return np.concatenate([value(each) for each in by_block])


# --- ways: each gives what (rays) → (seconds, seconds for other lights, colours) does


def ours(blocks):
    def cast(rays):
        start = time.process_time()
        among = {"occluders": [BULB]}
        seen = blocks.phong.visibility(scene(ALL_BOUNCES), samples=rays)
        how = among | {"transport": blocks.phong.transport(samples=rays, **among), "visibility": seen}
        lit = blocks.phong.shade(scene(ALL_BOUNCES), MATERIALS, **how)
        again = time.process_time()
        blocks.phong.shade(scene(ALL_BOUNCES), MATERIALS, **how)
        done = time.process_time()
        return again - start, done - again, joined(lit, lambda block: block["phong"])

    return cast


def paths(blocks):
    def cast(rays):
        start = time.process_time()
        found = blocks.phong.truth(scene(0), MATERIALS, samples=rays, occluders=[BULB])
        return time.process_time() - start, np.nan, joined(found.values(), lambda truth: truth.rgb)

    return cast


def mitsuba(blocks):
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(THREADS)
    radiance = LAMP.intensity / LAMP.radius**2
    parts = {"type": "scene", "lamp": {
        "type": "sphere", "center": list(LAMP.position), "radius": LAMP.radius,
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [radiance] * 3}},
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}}  # fmt: skip
    for name, block in zip(blocks.keys(), blocks, strict=True):
        bsdf = mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": list(COLORS[name])}})
        properties = mi.Properties()
        properties["bsdf"] = bsdf
        shape = mi.Mesh(name, block.n_points, block.n_cells, props=properties)
        parameters = mi.traverse(shape)
        parameters["vertex_positions"] = np.ravel(block.points).astype(np.float32)
        parameters["faces"] = block.regular_faces.astype(np.uint32).ravel()
        parameters.update()
        parts[name] = shape
    whole, integrator = mi.load_dict(parts), mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})
    places, normals = joined(blocks, lambda block: inward(block)), joined(blocks, lambda block: block.point_normals)

    def cast(rays):
        start = time.process_time()
        count = len(places) * rays
        sampler = mi.load_dict({"type": "independent", "sample_count": rays})
        sampler.seed(rays, count)
        row = dr.arange(mi.UInt32, count) // rays
        p = dr.gather(mi.Point3f, mi.Point3f(places.T.astype(np.float32)), row)
        n = dr.gather(mi.Vector3f, mi.Vector3f(normals.T.astype(np.float32)), row)
        ray = mi.RayDifferential3f(mi.Ray3f(p + 1e-3 * n, -n))
        found, _, _ = integrator.sample(whole, sampler, ray)
        colors = np.stack([np.array(dr.block_sum(found[channel], rays)) / rays for channel in range(3)], axis=1)
        return time.process_time() - start, np.nan, colors

    return cast


def inward(block):
    """Points, moved a little into a face of theirs: rays that hit a corner would slip through between faces."""
    moved = np.array(block.points, np.float64)
    middles = block.points[block.regular_faces].mean(axis=1)
    for corner in range(3):
        vertices = block.regular_faces[:, corner]
        moved[vertices] = block.points[vertices] + 1e-3 * (middles - block.points[vertices])
    return moved


_BAKE = """
import sys, time
import bpy, numpy as np
data, rays, threads = np.load(sys.argv[1]), int(sys.argv[3]), int(sys.argv[4])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine, scene.render.threads_mode, scene.render.threads = "CYCLES", "FIXED", threads
scene.cycles.device, scene.cycles.use_adaptive_sampling = "CPU", False
scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 64
light = bpy.data.lights.new("light", "POINT")
light.shadow_soft_size, light.use_soft_falloff, light.energy = float(data["radius"]), False, 4 * np.pi**2
lamp = bpy.data.objects.new("lamp", light)
lamp.location = data["place"].tolist()
scene.collection.objects.link(lamp)
things = []
for number in range(int(data["count"])):
    mesh = bpy.data.meshes.new(str(number))
    mesh.from_pydata(data[f"points{number}"].tolist(), [], data[f"corners{number}"].tolist())
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
taken = []
for scene.cycles.samples, scene.cycles.seed in ((1, 0), (rays, rays)):
    start = time.process_time()
    bpy.ops.object.bake(target="VERTEX_COLORS", type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT", "COLOR"})
    taken.append(time.process_time() - start)
seen = []
for thing in things:
    part = np.zeros((len(thing.data.vertices), 4), np.float32)
    thing.data.color_attributes["seen"].data.foreach_get("color", part.ravel())
    seen.append(part[:, :3])
np.savez(sys.argv[2], seen=np.concatenate(seen), seconds=(taken[1] - taken[0]) * rays / max(rays - 1, 1))
"""


def blender(blocks, python, judge):
    if python is None:
        raise FileNotFoundError("no Python with bpy was named")
    data = {f"points{number}": np.array(block.points) for number, block in enumerate(blocks)}
    data |= {f"corners{number}": np.array(block.regular_faces) for number, block in enumerate(blocks)}
    data |= {"colors": np.array([COLORS[name] for name in blocks.keys()]), "count": blocks.n_blocks}  # noqa: SIM118
    data |= {"place": np.array(LAMP.position), "radius": LAMP.radius}

    def cast(rays):
        with tempfile.TemporaryDirectory() as folder:
            given, result = Path(folder) / "given.npz", Path(folder) / "result.npz"
            np.savez(given, **data)
            command = [python, "-c", _BAKE, str(given), str(result), str(rays), str(THREADS)]
            subprocess.run(command, check=True, capture_output=True)
            with np.load(result) as found:
                scale = np.vdot(found["seen"], judge) / np.vdot(found["seen"], found["seen"])
                return float(found["seconds"]), np.nan, scale * found["seen"]

    return cast


def compare(cells, python):
    """Rows of the table: way, rays, seconds, relative RMS error; and seconds at equal error by way."""
    blocks = room(cells)
    judge = blocks.phong.truth(scene(0), MATERIALS, samples=JUDGE_PATHS, occluders=[BULB])
    true = joined(judge.values(), lambda each: each.rgb)
    noise = joined(judge.values(), lambda each: each.standard_error)
    ways = {OURS: (lambda: ours(blocks), (16, 64, 256, 1024))}
    ways |= {"mesh.phong.truth": (lambda: paths(blocks), (16, 64, 256))}
    ways |= {"Mitsuba's path integrator": (lambda: mitsuba(blocks), (16, 64, 256))}
    ways |= {"Blender's bake": (lambda: blender(blocks, python, true), (16, 64))}
    rows, curves, missing = [], {}, {}
    for name, (make, counts) in ways.items():
        try:
            cast = make()
            cast(counts[0])  # compiles
            for rays in counts:
                seconds, again, colors = cast(rays)
                square = np.square(colors - true).mean() - np.square(noise).mean()
                error = float(np.sqrt(max(square, 1e-12)) / true.mean())
                rows.append((name, rays, seconds, again, error))
                curves.setdefault(name, []).append((seconds, error))
        except (ImportError, FileNotFoundError, subprocess.CalledProcessError) as reason:
            missing[name] = str(reason)
    return len(true), rows, curves, missing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cells", nargs="?", type=int, default=30)
    parser.add_argument("--blender", metavar="PYTHON", help="one that imports bpy")
    options = parser.parse_args()
    count, rows, curves, missing = compare(options.cells, options.blender)
    shown = table(f"all bounces at {count} vertices", "way", "rays", "seconds", "again", "relative RMS error")
    for name, rays, seconds, again, error in rows:
        relit = "" if np.isnan(again) else f"{again:.3f}"
        shown.add_row(name, str(rays), f"{seconds:.2f}", relit, f"{error:.4f}")
    for name, reason in missing.items():
        shown.add_row(name, "", "", "", f"missing: {reason}"[:60])
    console = Console()
    console.print(shown)
    own = curves[OURS]
    for name, curve in curves.items():
        numbers, errors = zip(*[(rays, error) for way, rays, _, _, error in rows if way == name], strict=True)
        print(f"{name}: errors as rays to the power {slope(numbers, errors):.2f}")
        if name != OURS:
            seconds, error = own[2]
            ratio = equal_error_seconds(curve, error) / seconds
            print(f"    at the error of our {rows[2][1]} rays: {ratio:.1f} times as long")


if __name__ == "__main__":
    main()
