"""Thirty scenes keep their colours, within the documented bounds, and their plans.

`python tests/test_golden.py` records both again in `golden.json`, with the reference's colours in float64. The oracles
test whether colours are right; this test detects changes.
"""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import pvphong as ph

RECORD = Path(__file__).with_name("golden.json")

VIEWER = ph.Viewer(position=(2.0, -3.0, 2.5), up=(0, 0, 1))
LAMP = ph.PointLight(position=(1.5, -2, 2), attenuation=(0.5, 0.2, 0.1), ambient=0.1)

# Vertices of a unit sphere, along a spiral; every other normal is near the middle of the lamp's highlight.
k = np.arange(7) + 0.5
HEIGHT = 1.0 - 2.0 * k / len(k)
POINTS = np.stack([np.cos(2.4 * k), np.sin(2.4 * k), HEIGHT / np.sqrt(1.0 - HEIGHT**2)], axis=1)
POINTS *= np.sqrt(1.0 - HEIGHT**2)[:, None]
NORMALS = POINTS * (1.0, 0.6, 1.4)
for place in (LAMP.position, VIEWER.position):
    towards = np.array(place) - POINTS[::2]
    NORMALS[::2] += 300.0 * towards / np.linalg.norm(towards, axis=1, keepdims=True)

PLASTIC = ph.Material(ambient=0.1, diffuse=(0.2, 0.3, 0.8), specular=0.5, shininess=30.0, emission=(0.01, 0.0, 0.02))
GLOSSY = replace(PLASTIC, diffuse=0.3, specular=(0.4, 0.2, 0.1))

SUN = ph.DirectionalLight(direction=(-1, 1, -2), diffuse=(1, 0.9, 0.8))
SPOT = ph.SpotLight(position=(2, -2, 2), direction=(-2, 2, -2.2), cone_angle=25, exponent=8, attenuation=(1, 0, 0.02))
SPHERE = ph.SphereLight(position=(1.5, -1.5, 2), radius=0.6, intensity=4.0)
RECTANGLE = ph.RectangleLight(position=(1, -1.5, 2), direction=(-1, 1.5, -2), width=1.5, height=0.5, intensity=4.0)
DISK = ph.DiskLight(position=(1, -1.5, 2), direction=(-1, 1.5, -2), radius=0.7, intensity=4.0, two_sided=True)
POLYGON = ph.PolygonLight(corners=[(1, -2, 2), (2, -1, 2), (0.5, -0.5, 2.5)], intensity=4.0, two_sided=True)
TEXELS = np.array([[(0.1, 0.2, 0.6)] * 4, [(2.0, 1.0, 0.5), (0.2, 0.2, 0.2), (0.3, 0.1, 0.1), (0.2, 0.4, 0.1)]])
SKY = ph.EnvironmentLight(image=TEXELS, up=(0, 0, 1), rotation=30.0)

LIGHTS = {"sun": SUN, "lamp": LAMP, "spot": SPOT, "sphere": SPHERE, "rectangle": RECTANGLE}
LIGHTS |= {"disk": DISK, "polygon": POLYGON, "sky": SKY}

REFLECTANCES = {
    "blinn-phong": ph.BlinnPhong(),
    "modified phong": ph.ModifiedPhong(),
    "metal": ph.Metal(color=(1.0, 0.8, 0.3), shininess=40.0),
    "oren-nayar": ph.OrenNayar(sigma=25.0),
    "retro": ph.Retro(shininess=10.0),
    "ggx": ph.GGX(roughness=0.5, f0=(1.0, 0.8, 0.3)),
    "pbr": ph.PBR(metallic=0.3, roughness=0.5),
}

SHEAR, MIRROR, FAR = np.eye(4), np.diag([1.0, -0.5, 1.0, 1.0]), np.eye(4)
SHEAR[0, 1], FAR[:3, 3] = 1.5, 1e9


def scene_of(*lights, **model):
    return ph.Scene(lights, VIEWER, ph.LightModel(**model))


CASES = {
    **{name: {"scene": scene_of(light)} for name, light in LIGHTS.items()},
    **{
        f"{name} under a lamp": {"scene": scene_of(LAMP, SUN), "material": replace(GLOSSY, reflectance=reflectance)}
        for name, reflectance in REFLECTANCES.items()
    },
    "ggx under a sphere": {"scene": scene_of(SPHERE), "material": replace(GLOSSY, reflectance=ph.GGX(roughness=0.6))},
    "all lights": {"scene": scene_of(*LIGHTS.values())},
    "two-sided": {"scene": scene_of(SUN, LAMP, two_sided=True)},
    "not clamped": {"scene": scene_of(SUN, LAMP, replace(SPOT, intensity=9.0), clamp=False)},
    "parallel projection": {"scene": ph.Scene([SUN, LAMP], replace(VIEWER, parallel=True))},
    "viewer at infinity": {"scene": scene_of(SUN, LAMP, local_viewer=False)},
    "VTK's convention": {"scene": ph.Scene([SUN, SPOT], VIEWER, ph.LightModel.vtk())},
    "OpenGL's defaults": {"scene": ph.Scene([SUN, LAMP], VIEWER, ph.LightModel.opengl())},
    "headlight": {"scene": scene_of(replace(SPOT, frame="headlight"))},
    "a steep highlight": {"scene": scene_of(LAMP), "material": replace(PLASTIC, shininess=1e4)},
    "mirrored": {"scene": scene_of(SUN, LAMP), "matrix": MIRROR},
    "sheared": {"scene": scene_of(SUN, LAMP, RECTANGLE), "matrix": SHEAR},
    "far away": {"scene": scene_of(SUN, replace(LAMP, position=(1e9 + 2, 1e9 - 2, 1e9 + 2))), "matrix": FAR},
    "albedo": {"scene": scene_of(SUN, LAMP), "material": replace(PLASTIC, albedo=np.abs(POINTS))},
    "tolerance": {"scene": scene_of(SUN, LAMP, SPHERE), "tolerance": 1 / 255},
}
"""Name → arguments of `evaluate`."""


def colors(case, **options):
    arguments = {"material": PLASTIC} | case
    return ph.evaluate(POINTS, NORMALS, arguments.pop("scene"), arguments.pop("material"), **arguments, **options).rgb


def planned(case):
    """Return each effect with + if it runs and - if not, the inputs, and the error bound."""
    options = {key: case[key] for key in ("matrix", "tolerance") if key in case}
    plan = ph.plan(POINTS, case["scene"], case.get("material", PLASTIC), **options)
    effects = " ".join(f"{'+' if decision.on else '-'}{name}" for name, decision in plan.effects.items())
    return f"{effects}; reads {', '.join(sorted(plan.needs)) or 'nothing'}; {plan.error_bound:.6g}"


def test_there_are_some_thirty_scenes_and_all_are_recorded():
    assert len(CASES) == 30
    assert set(json.loads(RECORD.read_text(encoding="utf-8"))) == set(CASES)


@pytest.mark.parametrize("name", CASES)
def test_colours_and_plans_are_those_recorded(name):
    recorded, case = json.loads(RECORD.read_text(encoding="utf-8"))[name], CASES[name]
    assert planned(case) == recorded["plan"]
    expected = np.array(recorded["rgb"])
    material = case.get("material", PLASTIC)
    # as documented for `evaluate`, for each light; closed forms are good to 1e-9, microfacets lose digits with α
    rounding = (1 + len(case["scene"].lights)) * (4.0 * math.sqrt(material.shininess) + 16.0)
    roughness = getattr(material.reflectance, "roughness", 1.0)
    for precision, u in (("float64", 2.0**-53), ("float32", 2.0**-24)):
        bound = rounding * u / roughness**4 + (1e-9 if precision == "float64" else 0.0)
        for backend in ("numpy", "auto"):
            error = np.abs(colors(case, precision=precision, backend=backend) - expected).max()
            assert error <= bound * max(np.abs(expected).max(), 1.0), (precision, backend)


def record():
    """Record the reference's current results."""
    scenes = {
        name: {"plan": planned(case), "rgb": colors(case, precision="float64", backend="numpy").tolist()}
        for name, case in CASES.items()
    }
    lines = [f"{json.dumps(name)}: {json.dumps(scene)}" for name, scene in scenes.items()]
    RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    record()
