"""Script for Blender's Python that bakes vertex colours: `python blender_bake.py DATA RESULT RAYS THREADS`.

The data are meshes, the number of meshes to bake, their colours, the number of bounces, and lamps by position, radius
and power. Without lamps, the sky is baked. The time of a bake with one sample is subtracted from the seconds.
"""

import sys
import time

import bpy
import numpy as np

data, rays = np.load(sys.argv[1]), int(sys.argv[3])
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine, scene.render.threads_mode, scene.render.threads = "CYCLES", "FIXED", int(sys.argv[4])
scene.cycles.device, scene.cycles.use_adaptive_sampling = "CPU", False
scene.cycles.max_bounces = scene.cycles.diffuse_bounces = int(data["bounces"])
if not len(data["places"]):
    scene.world = bpy.data.worlds.new("world")
    scene.world.light_settings.distance = 1e6
for place, radius, power in zip(data["places"], data["radii"], data["powers"], strict=True):
    light = bpy.data.lights.new("light", "POINT")
    light.shadow_soft_size, light.use_soft_falloff, light.energy = float(radius), False, 4 * np.pi**2 * float(power)
    lamp = bpy.data.objects.new("lamp", light)
    lamp.location = place.tolist()
    scene.collection.objects.link(lamp)
looking = []
for number in range(int(data["count"])):
    mesh = bpy.data.meshes.new(str(number))
    mesh.from_pydata(data[f"points{number}"].tolist(), [], data[f"corners{number}"].tolist())
    mesh.shade_smooth()
    thing = bpy.data.objects.new(str(number), mesh)
    scene.collection.objects.link(thing)
    if number >= data["looking"]:
        continue
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
    thing.select_set(True)
    looking.append(thing)
bpy.context.view_layer.objects.active = looking[0]
arriving = {"DIRECT", "COLOR"} | ({"INDIRECT"} if data["bounces"] else set())
how = {"type": "DIFFUSE", "pass_filter": arriving} if len(data["places"]) else {"type": "AO"}
taken = []
for scene.cycles.samples, scene.cycles.seed in ((1, 0), (rays, rays)):
    start = time.process_time()
    bpy.ops.object.bake(target="VERTEX_COLORS", **how)
    taken.append(time.process_time() - start)
seen = []
for thing in looking:
    part = np.zeros((len(thing.data.vertices), 4), np.float32)
    thing.data.color_attributes["seen"].data.foreach_get("color", part.ravel())
    seen.append(part[:, :3])
seconds = (taken[1] - taken[0]) * rays / (rays - 1) if rays > 1 else taken[1]
np.savez(sys.argv[2], seen=np.concatenate(seen), seconds=seconds)
