"""Lamps as measured: Radiance's reading of the same files, closed forms, symmetries, broken files."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import radiance
from photometric_files import eulumdat, ies
from scipy.interpolate import RegularGridInterpolator
from strategies import unit

import pvphong as ph
from pvphong.optics.lights import is_in_vtk, nearest_in_vtk
from pvphong.optics.photometry import Photometry

V = np.arange(0.0, 91.0, 5.0)
RANDOM = np.random.default_rng(63)
WAYS = RANDOM.normal(size=(200, 3))
WAYS /= np.linalg.norm(WAYS, axis=1)[:, None]


def candela(light, ways=WAYS, precision="float64", **options):
    """Return intensities in some directions: the irradiance of a surface that faces the lamp, times d²."""
    points = np.array(light.position) + 3.0 * ways
    white = ph.Material(ambient=0.0, diffuse=1.0)
    scene = ph.Scene([light], light_model=ph.LightModel(ambient=0.0, clamp=False))
    return 9.0 * ph.evaluate(points, -ways, scene, white, precision=precision, **options).rgb[:, 0]


def cosines(vertical, horizontal=(0.0,), amount=0.0):
    """Return the intensities of a lamp of 1000 cos V candela that varies with the horizontal angle."""
    around = 1.0 + amount * np.sin(np.radians(horizontal)) + 0.5 * amount * np.cos(2 * np.radians(horizontal))
    return np.maximum(1000.0 * np.cos(np.radians(vertical)), 0.0) * around[:, None]


# --- closed forms


def test_a_lamp_gives_its_intensity_over_the_squared_distance(tmp_path):
    lamp = ph.PhotometricLight(ies(tmp_path / "a.ies", V, [0], cosines(V)), position=(0.2, 0.1, 4.0), name="lamp")
    floor = pv.Plane(center=(0.2, 0.1, 0.0), i_size=4, j_size=4)
    found = floor.phong.irradiance(lamp)["irradiance"][:, 0]
    distance = np.linalg.norm(floor.points - np.array(lamp.position), axis=1)
    cosine = 4.0 / distance
    np.testing.assert_allclose(found, 1000.0 * cosine**2 / distance**2, rtol=2e-3)  # linear between 5° steps
    middle = np.argmin(distance)
    assert found[middle] == pytest.approx(1000.0 / 16.0, rel=1e-6)
    assert lamp.measured.lumens == pytest.approx(1000.0 * math.pi, rel=2e-3)


def test_a_number_is_the_intensity_in_all_directions():
    lamp = ph.PhotometricLight(120.0, position=(1.0, 2.0, 3.0), intensity=0.5)
    np.testing.assert_allclose(candela(lamp), 60.0, rtol=1e-12)
    assert lamp.measured.lumens == pytest.approx(4.0 * math.pi * 120.0)


def test_flux_is_the_integral_of_the_intensities(tmp_path):
    horizontal = np.arange(0.0, 361.0, 15.0)
    lamp = ph.PhotometricLight(ies(tmp_path / "a.ies", V, horizontal, cosines(V, horizontal, 0.3)))
    t, w = np.polynomial.legendre.leggauss(200)
    phi = np.arange(360) * math.pi / 180.0
    z = np.repeat((t - 1.0) / 2.0, len(phi))  # the lower half, exactly as far as the angles go
    level = np.sqrt(1.0 - z * z)
    ways = np.stack([level * np.cos(np.tile(phi, 200)), level * np.sin(np.tile(phi, 200)), z], axis=1)
    flux = (candela(lamp, ways) * np.repeat(w / 2.0, len(phi))).sum() * 2.0 * math.pi / len(phi)
    assert lamp.measured.lumens == pytest.approx(flux, rel=1e-4)


# --- types and symmetries


def to_angles(kind, ways, axes):
    """Return V and H in degrees, from the definitions of LM-63."""
    d, r, u = (ways @ axis for axis in axes)
    if kind == 1:
        return np.degrees(np.arccos(d)), np.degrees(np.arctan2(-r, u)) % 360.0
    if kind == 2:
        return np.degrees(np.arctan2(u, d)), np.degrees(np.arcsin(r))
    return np.degrees(np.arcsin(u)), np.degrees(np.arctan2(r, d))


@pytest.mark.parametrize("kind", [1, 2, 3])
@pytest.mark.parametrize("is_symmetric", [False, True])
def test_each_type_has_its_angles(kind, is_symmetric, tmp_path):
    vertical = np.arange(0.0, 181.0, 10.0) if kind == 1 else np.arange(0.0 if is_symmetric else -90.0, 91.0, 7.5)
    horizontal = np.arange(0.0, 361.0, 22.5) if kind == 1 else np.arange(0.0 if is_symmetric else -60.0, 61.0, 5.0)
    if kind == 1 and is_symmetric:
        horizontal = horizontal[horizontal <= 90.0]
    values = RANDOM.uniform(100.0, 1000.0, (len(horizontal), len(vertical)))
    if kind == 1:
        values[-1] = values[0] if not is_symmetric else values[-1]
    path = ies(tmp_path / "a.ies", vertical, horizontal, values, kind=kind)
    lamp = ph.PhotometricLight(path, (1, 2, 3), direction=(0.3, -0.2, -1.0), up=(0.5, 1.0, 0.3))
    v, h = to_angles(kind, WAYS, lamp.axes)
    if is_symmetric:
        v, h = (np.abs(v), np.abs(h)) if kind > 1 else (v, 90.0 - np.abs(90.0 - h % 180.0))
    read = RegularGridInterpolator((horizontal, vertical), values, bounds_error=False, fill_value=0.0)
    inside = (np.abs(h) < 59.9) | (kind == 1)  # at the edge, rounding decides
    outside = (np.abs(h) > 60.1) & (kind > 1)
    found = candela(lamp)
    np.testing.assert_allclose(found[inside], read(np.stack([h, v], axis=1))[inside], rtol=1e-7)
    assert not found[outside].any()
    assert inside.sum() > 50
    for precision, backend in (("float32", "numpy"), ("float32", "numba"), ("float64", "numba")):
        again = candela(lamp, precision=precision, backend=backend)
        bound = 5e-4 if precision == "float32" else 1e-12
        np.testing.assert_allclose(again[inside], found[inside], rtol=0, atol=1000.0 * bound)


@pytest.mark.parametrize("last", [0.0, 90.0, 180.0, 360.0, 270.0, 315.0])
def test_symmetries_of_type_c(last, tmp_path):
    """Each file is a part of the same symmetric lamp, from which symmetry makes the whole."""
    whole = np.arange(0.0, 361.0, 45.0)
    if last == 0.0:
        values = np.repeat(cosines(V), len(whole), axis=0)
    elif last == 90.0:
        values = cosines(V) * (2.0 + np.cos(2.0 * np.radians(whole)))[:, None]
    elif last == 180.0:
        values = cosines(V) * (2.0 + np.cos(np.radians(whole)))[:, None]
    elif last == 270.0:
        values = cosines(V) * (2.0 + np.sin(np.radians(whole)))[:, None]
    else:
        values = cosines(V) * (2.0 + np.cos(np.radians(whole - 45.0)) + np.sin(2.0 * np.radians(whole)))[:, None]
    kept = (whole >= (90.0 if last == 270.0 else 0.0)) & (whole <= last)
    part, all_of_it = ies(tmp_path / "a.ies", V, whole[kept], values[kept]), ies(tmp_path / "b.ies", V, whole, values)
    np.testing.assert_allclose(candela(ph.PhotometricLight(part)), candela(ph.PhotometricLight(all_of_it)), rtol=1e-12)


def test_factors_of_the_versions_of_the_standard(tmp_path):
    down = np.array([[0.0, 0.0, -1.0]])
    for head, factor in (("", 0.45), ("IESNA91", 0.45), ("IESNA:LM-63-1995", 0.9), ("IES:LM-63-2019", 0.9)):
        how = {"ballast": 0.9, "with_lamp": 0.5, "multiplier": 2, "lamps": 3, "head": head}
        lamp = ph.PhotometricLight(ies(tmp_path / "a.ies", V, [0], cosines(V), **how))
        assert candela(lamp, down)[0] == pytest.approx(2000.0 * factor), head


@pytest.mark.parametrize("symmetry", [0, 1, 2, 3, 4])
def test_eulumdat_says_the_same_as_ies(symmetry, tmp_path):
    around, turn = np.arange(0.0, 360.0, 30.0), np.radians(np.arange(0.0, 361.0, 30.0))
    shape = {0: np.cos(turn - 0.7), 1: 0 * turn, 2: np.cos(turn), 3: np.sin(turn), 4: np.cos(2 * turn)}[symmetry]
    whole = cosines(V) * (2.0 + shape)[:, None]
    kept = {0: range(12), 1: [0], 2: range(7), 3: [9, 10, 11, 0, 1, 2, 3], 4: range(4)}[symmetry]
    stored = whole[list(kept)] / 2.5  # for 2000 lumens and a conversion factor of 1.25
    path = eulumdat(tmp_path / "a.ldt", symmetry, around, V, stored, fluxes=(2000.0, 3000.0), conversion=1.25)
    same = ies(tmp_path / "a.ies", V, [*around, 360.0], whole)
    np.testing.assert_allclose(candela(ph.PhotometricLight(path)), candela(ph.PhotometricLight(same)), rtol=1e-8)


def test_a_tilted_lamp_has_the_factor_of_its_tilt(tmp_path):
    """The bare lamp along the aim (1), across the plane of 0° (2), or in it (3)."""
    turned = math.radians(30.0)
    in_plane = (math.sin(turned), 0.0, -math.cos(turned))
    across = (0.0, math.sin(turned), -math.cos(turned))
    for axis, direction, factor in (
        (1, (0, 0, -1), 1.0), (1, in_plane, 0.8), (1, across, 0.8), (1, (0, 0, 1), 0.1),
        (2, in_plane, 1.0), (2, across, 0.8), (3, in_plane, 0.8), (3, across, 1.0),
    ):  # fmt: skip
        tilt = f"TILT=INCLUDE\n{axis}\n4\n0 60 90 180\n1 .6 .5 .1"
        path = ies(tmp_path / "a.ies", V, [0], cosines(V), tilt=tilt)
        lamp = ph.PhotometricLight(path, direction=direction)
        assert candela(lamp, unit(np.array(direction, float))[None])[0] == pytest.approx(1000.0 * factor), (
            axis,
            direction,
        )
    (tmp_path / "tilt.txt").write_text("1\n2\n0 90\n1 .4\n")
    path = ies(tmp_path / "a.ies", V, [0], cosines(V), tilt="TILT=tilt.txt")
    assert candela(ph.PhotometricLight(path, direction=(1, 0, 0)), np.eye(3)[:1])[0] == pytest.approx(400.0)


def test_uneven_angles_are_kept_where_a_step_divides_them(tmp_path):
    vertical = [0.0, 2.5, 5.0, 15.0, 20.0, 47.5, 90.0]
    values = RANDOM.uniform(1.0, 100.0, (1, 7))
    lamp = ph.PhotometricLight(ies(tmp_path / "a.ies", vertical, [0], values))
    angles = np.radians(np.linspace(0.0, 89.9, 300))
    ways = np.stack([np.sin(angles), 0.0 * angles, -np.cos(angles)], axis=1)
    np.testing.assert_allclose(candela(lamp, ways), np.interp(np.degrees(angles), vertical, values[0]), rtol=1e-7)
    odd = [0.0, 3.17, 11.03, 33.34, 61.11, 90.0]
    lamp = ph.PhotometricLight(ies(tmp_path / "b.ies", odd, [0], cosines(np.array(odd))))
    off = candela(lamp, ways) - np.interp(np.degrees(angles), odd, cosines(np.array(odd))[0])
    assert np.abs(off).max() < 2.0


# --- Radiance

HORIZONTAL = np.arange(0.0, 361.0, 22.5)
RADIANCE = {
    "symmetric": {"vertical": V, "horizontal": [0], "candela": cosines(V)},
    "asymmetric": {"vertical": V, "horizontal": HORIZONTAL, "candela": cosines(V, HORIZONTAL, 0.4)},
    "bilateral": {"vertical": V, "horizontal": HORIZONTAL[:9], "candela": cosines(V, HORIZONTAL[:9], 0.4)},
    "up and down": {
        "vertical": np.arange(0.0, 181.0, 10.0),
        "horizontal": [0, 45, 90],
        "candela": [100.0 + factor * np.arange(19.0) ** 2 for factor in (1.0, 2.0, 3.0)],
    },
    "several lamps": {
        "vertical": V,
        "horizontal": [0],
        "candela": cosines(V),
        "lamps": 3,
        "multiplier": 1.5,
        "ballast": 0.8,
    },
    "before 1995": {
        "vertical": V,
        "horizontal": [0],
        "candela": cosines(V),
        "ballast": 0.8,
        "with_lamp": 0.9,
        "head": "IESNA91",
    },
    "tilt": {
        "vertical": V,
        "horizontal": HORIZONTAL,
        "candela": cosines(V, HORIZONTAL, 0.4),
        "tilt": "TILT=INCLUDE\n1\n3\n0 45 90\n0.9 .7 .5",
    },
    "type B": {
        "kind": 2,
        "vertical": np.arange(-90.0, 91.0, 7.5),
        "horizontal": np.arange(-90.0, 91.0, 10.0),
        "candela": 500.0 - np.abs(np.arange(-9.0, 10.0))[:, None] * 20.0 + 3.0 * np.arange(25.0),
    },
}


def of_radiance(path: Path, ways) -> np.ndarray:
    """Return intensities by `ies2rad` and `rtrace`, at 4 m from a small sphere."""
    radiance.run(path.parent, "ies2rad", "-dm", "-t", "default", "-i", "0.005", "-o", path.stem, path.name)
    options = ("-ab", "0", "-dj", "0", "-ds", "0", "-dt", "0", "-dc", "1")
    scene = path.with_suffix(".rad").read_text()
    watts = radiance.irradiance(path.parent, scene, 4.0 * ways, -ways, *options) @ (0.265, 0.670, 0.065)  # its weights
    return watts * radiance.WATTS_TO_LUMENS * 16.0


@pytest.mark.parametrize("lamp", RADIANCE)
def test_radiance_reads_the_same(lamp, tmp_path):
    """Within the measured angles: beyond them, Radiance lets the light fade. For type B, its angles are tangents of
    both components over the third, which are those of the standard in the planes of 0° only.
    """
    path = ies(tmp_path / "lamp.ies", **RADIANCE[lamp])
    ways = WAYS if RADIANCE[lamp]["vertical"][-1] > 90 else WAYS[WAYS[:, 2] < -0.02]
    if lamp == "type B":
        angles = np.radians(np.linspace(-85.0, 85.0, 60))
        planes = [
            np.stack([np.sin(angles), 0 * angles, -np.cos(angles)]),
            np.stack([0 * angles, np.sin(angles), -np.cos(angles)]),
        ]
        ways = np.concatenate(planes, axis=1).T
    found, expected = candela(ph.PhotometricLight(path), ways), of_radiance(path, ways)
    assert len(ways) > 80
    np.testing.assert_allclose(found, expected, rtol=0.01, atol=1e-3)
    assert abs((found / expected).mean() - 1.0) < 0.002


# --- fields, files, VTK


def test_a_scene_file_keeps_the_numbers(tmp_path):
    path = ies(tmp_path / "a.ies", V, HORIZONTAL, cosines(V, HORIZONTAL, 0.3), tilt="TILT=INCLUDE\n2\n2\n0 90\n1 .5")
    scene = ph.Scene([ph.PhotometricLight(path, (0, 0, 3), name="lamp")])
    scene.save(tmp_path / "rig.json")
    path.unlink()
    loaded = ph.Scene.load(tmp_path / "rig.json")
    assert loaded == scene
    assert hash(loaded.lights[0]) == hash(scene.lights[0])
    np.testing.assert_array_equal(candela(loaded.lights[0]), candela(scene.lights[0]))
    assert (tmp_path / "rig.json").stat().st_size < 20_000
    assert "19 x 17 angles" in repr(loaded.lights[0])


def test_vtk_draws_a_lamp_of_the_same_flux(tmp_path):
    spot = ies(tmp_path / "a.ies", V, [0], 1000.0 * np.cos(np.radians(V))[None] ** 5)
    lamp = ph.PhotometricLight(spot, (1, 2, 3), (1, 0, -1))
    assert not is_in_vtk(lamp)
    drawn = nearest_in_vtk(lamp)
    assert drawn.exponent == pytest.approx(5.0, rel=0.01)
    assert 1.0 / drawn.attenuation[2] == pytest.approx(1000.0)
    even = nearest_in_vtk(ph.PhotometricLight(50.0, (1, 2, 3)))
    assert isinstance(even, ph.PointLight)
    assert 1.0 / even.attenuation[2] == pytest.approx(50.0)


def test_a_plan_bounds_a_lamp_by_its_largest_intensity(tmp_path):
    path = ies(tmp_path / "a.ies", V, [0], cosines(V))
    ball = pv.Sphere(center=(0, 0, -100.0))
    weak = ball.phong.plan(ph.Scene([ph.PhotometricLight(path, intensity=1e-3)]), tolerance=1e-3)
    assert not weak.effects["lights"].on
    assert ball.phong.plan(ph.Scene([ph.PhotometricLight(path)]), tolerance=1e-3).effects["lights"].on


def test_shadows_of_a_lamp_are_hard(tmp_path):
    lamp = ph.PhotometricLight(ies(tmp_path / "a.ies", V, [0], cosines(V)), (0, 0, 3))
    floor = pv.Plane(i_size=4, j_size=4)
    seen = floor.phong.visibility(lamp, occluders=[pv.Sphere(radius=0.5, center=(0, 0, 1.5))]).per_light
    assert set(seen.ravel().tolist()) == {0.0, 1.0}


# --- files that are wrong

GOOD = {"vertical": [0, 45, 90], "horizontal": [0, 90], "candela": [[3, 2, 1], [3, 1, 0]]}
BROKEN = [
    ({"vertical": [0, 90, 45]}, "vertical angles must be finite and ascending; got 0 90 45"),
    ({"vertical": [0, 45, 190]}, "vertical angles must be two or more, from 0 to 180 for type C; got 0 45 190"),
    ({"horizontal": [0, 100]}, "horizontal angles must be 0 to 0, 90, 180 or 360 degrees, or 90 to 270, for type C"),
    ({"kind": 4}, "the photometric type must be 1, 2 or 3; got 4"),
    ({"kind": 2, "horizontal": [0, 100]}, "horizontal angles must be two or more, from -90 or 0 up to 90 degrees"),
    ({"multiplier": 0}, "the product of multiplier and ballast factors must be positive; got 0"),
    ({"candela": [[3, -2, 1], [3, 1, 0]]}, "candela must be finite numbers >= 0; got -2"),
    ({"candela": [[0, 0, 0], [0, 0, 0]]}, "candela must be numbers that are not all 0; got zeros only"),
    (
        {"candela": [[3, 2, 1], [3, 1, 0], [1, 1, 1]]},
        "there are 3 words after the last candela value, the first is '1'",
    ),
    ({"candela": [[3, 2, 1]]}, "the file is cut short: it ends after 3 of 6 numbers of the candela values"),
    ({"tilt": "TILT=none.tlt"}, "the tilt file none.tlt next to it cannot be read"),
    (
        {"tilt": "TILT=INCLUDE\n1\n2\n90 0\n1 1"},
        "tilt must be ascending angles, followed by the same number of factors >= 0",
    ),
    (
        {"tilt": "TILT=INCLUDE\n5\n2\n0 90\n1 1"},
        "the lamp-to-luminaire geometry of the tilt must be a whole number from 1",
    ),
    ({"tilt": "no tilt"}, "there is no line TILT=…; the file may be cut short"),
    ({"multiplier": "x"}, "'x' among the multiplier is not a number"),
]


@pytest.mark.parametrize(("change", "message"), BROKEN, ids=lambda value: str(value)[:40])
def test_a_file_that_contradicts_itself_gets_one_line(change, message, tmp_path):
    path = ies(tmp_path / "lamp.ies", **GOOD | change)
    with pytest.raises(
        ValueError, match=r"^photometry must be an IES \(LM-63\) or EULUMDAT file; got .*lamp\.ies"
    ) as told:
        ph.PhotometricLight(path)
    assert message in str(told.value)
    assert "\n" not in str(told.value)


def test_a_file_that_is_cut_is_refused_wherever_the_cut_is(tmp_path):
    for path in (
        ies(tmp_path / "a.ies", **GOOD),
        eulumdat(tmp_path / "a.ldt", 4, [0, 90, 180, 270], [0, 45, 90], [[3, 2, 1], [3, 1, 11]]),
    ):
        words = path.read_bytes().split(b"\r\n")
        assert ph.PhotometricLight(path).measured.most > 0.0
        for count in range(len(words) - 1):
            path.write_bytes(b"\r\n".join(words[:count]) + b"\r\n")
            with pytest.raises(ValueError, match=r"^photometry must be an IES .* file; got ") as told:
                ph.PhotometricLight(path)
            assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("line", "text", "message"),
    [
        (3, "7", "line 3, the symmetry, must be 0, 1, 2, 3 or 4; got 7"),
        (4, "5", "5 C-planes at these angles do not fit the symmetry 4"),
        (6, "many", "line 6, the number of angles in a C-plane, must be a number; got 'many'"),
        (29, "0", "flux times conversion factor must be positive; got 0 times 1"),
        (43, "1", "horizontal angles must be"),
    ],
)
def test_a_wrong_line_of_eulumdat_is_named(line, text, message, tmp_path):
    symmetry = 4 if line < 43 else 0
    values = [[3, 2, 1]] * (2 if symmetry else 4)
    path = eulumdat(tmp_path / "a.ldt", symmetry, [0, 90, 180, 270], [0, 45, 90], values)
    lines = path.read_text().splitlines()
    lines[line - 1] = text
    path.write_text("\n".join(lines))
    with pytest.raises(ValueError, match=r"^photometry must be") as told:
        ph.PhotometricLight(path)
    assert message in str(told.value)


@pytest.mark.parametrize("given", [-1.0, 0.0, "no.ies", None, [1, 2], b"\0"])
def test_what_is_no_file_is_refused(given):
    with pytest.raises(ValueError, match=r"^photometry must be "):
        ph.PhotometricLight(given)


def test_bytes_of_another_kind_of_file_are_refused(tmp_path):
    for content in (b"", b"\x89PNG\r\n\x1a\n\0\0", b"TILT=NONE", bytes(range(256)) * 50):
        path = tmp_path / "a.dat"
        path.write_bytes(content)
        with pytest.raises(ValueError, match=r"^photometry must be an IES \(LM-63\) or EULUMDAT file; got "):
            ph.PhotometricLight(path)


def test_a_photometry_is_a_value():
    made = Photometry("C", "0 90", "0", ("10 0.1",))
    assert made == dataclasses.replace(made)
    assert made != dataclasses.replace(made, candela=("10 0.2",))
    assert (made.angles[0].tolist(), made.most) == ([0.0, 90.0], 10.0)
