"""Materials by name: the classic ones of OpenGL teaching, and some with their own reflectance.

Each classic material is a tuple of ambient, diffuse, specular, and shininess / 128. The values are from M. Kilgard's
`teapots.c` in the OpenGL Programming Guide's examples (Silicon Graphics, 1994), and from the table that courses have
copied from it since.
"""

from __future__ import annotations

from typing import Any

from pvphong.base.types import Vector
from pvphong.optics.reflectances import GGX, Metal, OrenNayar, Reflectance, Retro, Ward


def _grey(value: float) -> Vector:
    return value, value, value


NAMED: dict[str, tuple[Vector, Vector, Vector, float]] = {
    "emerald": ((0.0215, 0.1745, 0.0215), (0.07568, 0.61424, 0.07568), (0.633, 0.727811, 0.633), 0.6),
    "jade": ((0.135, 0.2225, 0.1575), (0.54, 0.89, 0.63), _grey(0.316228), 0.1),
    "obsidian": ((0.05375, 0.05, 0.06625), (0.18275, 0.17, 0.22525), (0.332741, 0.328634, 0.346435), 0.3),
    "pearl": ((0.25, 0.20725, 0.20725), (1.0, 0.829, 0.829), _grey(0.296648), 0.088),
    "ruby": ((0.1745, 0.01175, 0.01175), (0.61424, 0.04136, 0.04136), (0.727811, 0.626959, 0.626959), 0.6),
    "turquoise": ((0.1, 0.18725, 0.1745), (0.396, 0.74151, 0.69102), (0.297254, 0.30829, 0.306678), 0.1),
    "brass": (
        (0.329412, 0.223529, 0.027451),
        (0.780392, 0.568627, 0.113725),
        (0.992157, 0.941176, 0.807843),
        27.8974 / 128,
    ),
    "bronze": ((0.2125, 0.1275, 0.054), (0.714, 0.4284, 0.18144), (0.393548, 0.271906, 0.166721), 0.2),
    "polished bronze": ((0.25, 0.148, 0.06475), (0.4, 0.2368, 0.1036), (0.774597, 0.458561, 0.200621), 0.6),
    "chrome": (_grey(0.25), _grey(0.4), _grey(0.774597), 0.6),
    "copper": ((0.19125, 0.0735, 0.0225), (0.7038, 0.27048, 0.0828), (0.256777, 0.137622, 0.086014), 0.1),
    "polished copper": ((0.2295, 0.08825, 0.0275), (0.5508, 0.2118, 0.066), (0.580594, 0.223257, 0.0695701), 0.4),
    "gold": ((0.24725, 0.1995, 0.0745), (0.75164, 0.60648, 0.22648), (0.628281, 0.555802, 0.366065), 0.4),
    "polished gold": ((0.24725, 0.2245, 0.0645), (0.34615, 0.3143, 0.0903), (0.797357, 0.723991, 0.208006), 0.65),
    "pewter": (
        (0.105882, 0.058824, 0.113725),
        (0.427451, 0.470588, 0.541176),
        (0.333333, 0.333333, 0.521569),
        9.84615 / 128,
    ),
    "silver": (_grey(0.19225), _grey(0.50754), _grey(0.508273), 0.4),
    "polished silver": (_grey(0.23125), _grey(0.2775), _grey(0.773911), 0.7),
    "black plastic": (_grey(0.0), _grey(0.01), _grey(0.5), 0.25),
    "cyan plastic": ((0.0, 0.1, 0.06), (0.0, 0.50980392, 0.50980392), _grey(0.50196078), 0.25),
    "green plastic": (_grey(0.0), (0.1, 0.35, 0.1), (0.45, 0.55, 0.45), 0.25),
    "red plastic": (_grey(0.0), (0.5, 0.0, 0.0), (0.7, 0.6, 0.6), 0.25),
    "white plastic": (_grey(0.0), _grey(0.55), _grey(0.7), 0.25),
    "yellow plastic": (_grey(0.0), (0.5, 0.5, 0.0), (0.6, 0.6, 0.5), 0.25),
    "black rubber": (_grey(0.02), _grey(0.01), _grey(0.4), 0.078125),
    "cyan rubber": ((0.0, 0.05, 0.05), (0.4, 0.5, 0.5), (0.04, 0.7, 0.7), 0.078125),
    "green rubber": ((0.0, 0.05, 0.0), (0.4, 0.5, 0.4), (0.04, 0.7, 0.04), 0.078125),
    "red rubber": ((0.05, 0.0, 0.0), (0.5, 0.4, 0.4), (0.7, 0.04, 0.04), 0.078125),
    "white rubber": (_grey(0.05), _grey(0.5), _grey(0.7), 0.078125),
    "yellow rubber": ((0.05, 0.05, 0.0), (0.5, 0.5, 0.4), (0.7, 0.7, 0.04), 0.078125),
}


def _scattering(color: float | Vector, reflectance: Reflectance, **more: Any) -> dict[str, Any]:
    """Return the fields of a material whose ambient and diffuse colour are both `color`; `more` are further fields."""
    return {"ambient": color, "diffuse": color, "reflectance": reflectance, **more}


def _metal(color: Vector, shininess: float) -> dict[str, Any]:
    """Return the fields of a material with the reflectance `Metal`; its diffuse colour is a fifth of `color`.

    `color` is the metal's linear reflectance at normal incidence, from N. Hoffman's SIGGRAPH courses. `shininess` is
    the exponent of the highlight.
    """
    red, green, blue = color
    return _scattering((0.2 * red, 0.2 * green, 0.2 * blue), Metal(color, shininess))


WITH_REFLECTANCE: dict[str, dict[str, Any]] = {
    "metallic gold": _metal((1.0, 0.78, 0.34), 40.0),
    "metallic silver": _metal((0.95, 0.93, 0.88), 40.0),
    "metallic copper": _metal((0.95, 0.64, 0.54), 40.0),
    "metallic aluminium": _metal((0.91, 0.92, 0.92), 25.0),
    "chalk": _scattering(0.9, OrenNayar(30.0)),
    "clay": _scattering((0.6, 0.34, 0.24), OrenNayar(20.0)),
    "brushed steel": _scattering(0.15, Ward(0.08, 0.4), specular=0.55),
    "car paint": {"ambient": (0.3, 0.01, 0.02), "diffuse": (0.5, 0.01, 0.02), "reflectance": GGX(0.2, 0.06)},
    "road sign": _scattering((0.02, 0.12, 0.3), Retro(60.0), specular=(0.1, 0.3, 0.6)),
}
"""Name → fields of the material. Brushed steel needs tangents; the others work on any mesh."""
