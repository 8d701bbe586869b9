"""Integrals over polygons, disks and spheres, against mpmath integrals over their areas and against each other."""

import math
from itertools import pairwise, product

import area_oracle as oracle
import mpmath as mp
import numpy as np
import pytest

from pvphong.optics.area.disk import disk_highlight, disk_irradiance, sphere_highlight, sphere_irradiance
from pvphong.optics.area.lobes import BEYOND, SMOOTH_FROM, CosinePower, lobe_numbers
from pvphong.optics.area.polygon import angle_over_sine, polygon_highlight, polygon_irradiance

POWERS = (0.0, 0.3, 20.0, 1e4)
# Ratios of distance to size.
DISTANCES = (0.3, 2.0, 1e3, 1e8)
CASES = [(power, distance, is_cut) for power in POWERS for distance in DISTANCES for is_cut in (False, True)]


def unit(vector):
    return vector / np.linalg.norm(vector)


def thrown(power, distance, is_cut):
    """Return the random generator, the light's normal and a perpendicular, its offset, the vertex normal, the axis."""
    random = np.random.default_rng([int(10 * power), int(100 * distance), is_cut])
    facing = unit(random.normal(size=3))
    across = unit(np.cross(facing, random.normal(size=3)))
    way = -unit(facing + 0.8 * random.normal(size=3))
    middle = distance * (way if way @ facing < 0 else -way)
    l, seen = unit(middle), min(1.0 / distance, 1.0)
    cosine = random.uniform(-0.3, 0.3) * seen if is_cut else random.uniform(min(1.2 * seen, 0.9), 1.0)
    n = cosine * l + math.sqrt(1.0 - cosine**2) * unit(np.cross(l, random.normal(size=3)))
    spread = random.uniform(0.0, 0.9) * (seen + 1.0 / math.sqrt(power + 1.0))
    return random, facing, across, middle, n, unit(l + spread * random.normal(size=3))


def vector_area(offsets):
    return 0.5 * sum(np.cross(a, b) for a, b in zip(offsets, [*offsets[1:], offsets[0]], strict=True))


def taken(formulas, form, own, middle, n, axis):
    """Evaluate an integral over one or more lights, for vectors (3,) or (3, m)."""
    n, middle, axis = (np.reshape(x, (3, -1)) for x in (n, middle, axis if form.power else n))
    formula = formulas[0] if form.around == "normal" else formulas[1]
    with np.errstate(all="ignore"):
        return formula(own, lobe_numbers(form.power), middle, n, axis)


def of_polygon(form, axis, n, middle, offsets):
    area = vector_area(offsets)
    length = np.linalg.norm(area)
    size = max(np.linalg.norm(x) for x in offsets)
    own = [*area / length, 1.0, math.sqrt(length), size, float(len(offsets)), *np.ravel(offsets)]
    return float(taken((polygon_irradiance, polygon_highlight), form, own, middle, n, axis)[0])


def exact_of_polygon(axis, power, n, middle, offsets):
    """Return the exact integral over a convex polygon."""
    with mp.workdps(15 if np.linalg.norm(middle) < 10.0 else 30):
        way = oracle.exact_vector(middle)
        corners = [[a + b for a, b in zip(way, oracle.exact_vector(x), strict=True)] for x in offsets]
        inward = [oracle.unit(oracle.cross(b, a)) for a, b in pairwise([*corners, corners[0]])]
        caps = [(oracle.unit(oracle.exact_vector(n)), mp.mpf(0)), *((m, mp.mpf(0)) for m in inward)]
        first, total = corners[0], [mp.mpf(0)] * 3
        for b, c in pairwise(corners[1:]):
            part = oracle.cross(oracle.minus(b, first), oracle.minus(c, first))
            total = [x + y for x, y in zip(total, part, strict=True)]
        area = mp.sqrt(oracle.dot(total, total)) / 2
        return float(oracle.power_over(oracle.unit(oracle.exact_vector(axis)), power, caps) / area)


@pytest.mark.parametrize(("power", "distance", "is_cut"), CASES)
def test_a_power_over_a_polygon(power, distance, is_cut):
    random, facing, across, middle, n, w = thrown(power, distance, is_cut)
    turns = np.sort(random.uniform(0, 2 * math.pi, 5))
    offsets = [math.cos(t) * across + math.sin(t) * np.cross(facing, across) for t in turns]
    offsets = [x - np.mean(offsets, axis=0) for x in offsets]
    exact = exact_of_polygon(w, power, n, middle, offsets) * distance**2
    got = of_polygon(CosinePower("mirror", power), w, n, middle, offsets) * distance**2
    off = 1e-9 + is_cut * 1e-15 * distance  # the horizon's position depends on the rounding of n·p
    assert got == pytest.approx(exact, abs=off)
    assert of_polygon(CosinePower("mirror", power), w, n, middle, offsets[::-1]) == pytest.approx(got / distance**2)


@pytest.mark.parametrize("power", [4.0, 20.0, 300.0])
@pytest.mark.parametrize("rounded", [True, False])
def test_a_thin_strip_where_the_lobe_ends(power, rounded):
    """The cutoff drops at most zᵏ. If one long side alone is beyond it, a step of zᵖ would be a larger error."""
    random, count, length, width, distance = np.random.default_rng(0), 500, 1.4, 0.0146, 1e3
    lobe = lobe_numbers(power, rounded=rounded)
    with_step = [1.0 if place == BEYOND else number for place, number in enumerate(lobe)]
    end = (1.0 - lobe[BEYOND]) ** (1.0 / (power + 1.0))
    middle = distance * unit(np.array([0.3, 0.2, 1.0]))
    nodes, weights = np.polynomial.legendre.leggauss(12)
    errors = []
    for turn in np.linspace(0.0, math.pi, 9):
        along, across = np.array([(math.cos(turn), math.sin(turn), 0.0), (-math.sin(turn), math.cos(turn), 0.0)])
        offsets = [0.5 * (a * length * along + b * width * across) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        own = [0.0, 0.0, 1.0, 1.0, math.sqrt(length * width), 0.5 * math.hypot(length, width), 4.0, *np.ravel(offsets)]
        cosines = end + random.uniform(-2.0, 2.0, count) * length / distance
        aside = np.cross(middle, random.normal(size=(count, 3)))
        aside *= np.sqrt(1.0 - cosines**2)[:, None] / np.linalg.norm(aside, axis=1)[:, None]
        w = (cosines[:, None] * unit(middle) + aside).T
        vertices = np.tile(middle[:, None], count), np.tile(unit(middle)[:, None], count), w
        exact = np.zeros(count)
        for (a, first), (b, second) in product(zip(nodes, weights, strict=True), repeat=2):
            x = middle + 0.5 * (a * length * along + b * width * across)
            exact += 0.25 * first * second * np.maximum(unit(x) @ w, 0.0) ** power * x[2] / np.linalg.norm(x) ** 3
        errors.append(
            [abs(polygon_highlight(own, each, *vertices) - exact).max() * distance**2 for each in (lobe, with_step)]
        )
    got, naive = np.max(errors, axis=0)
    assert got <= 1.1 * end**power + (1e-7 if rounded else 1e-10)
    if power > SMOOTH_FROM:  # lower powers reach to the equator
        assert naive > 50.0 * got


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize("distance", DISTANCES)
def test_lamberts_cosine_over_a_polygon(distance, is_cut):
    _, facing, across, middle, n, _ = thrown(1.0, distance, is_cut)
    other = np.cross(facing, across)
    offsets = [0.4 * across + 0.3 * other, -0.4 * across + 0.3 * other, -0.4 * across - 0.3 * other]
    exact = exact_of_polygon(n, 1.0, n, middle, offsets)
    got = of_polygon(CosinePower("normal", 1.0), n, n, middle, offsets)
    assert got == pytest.approx(exact, rel=1e-9 + is_cut * 1e-14 * distance)


@pytest.mark.parametrize("degrees", [1e-140, 1e-8, 1e-3, 1.0, 20.0, 44.999, 45.001, 90.0, 135.001, 179.999])
def test_how_much_longer_an_arc_is_than_its_sine(degrees):
    """The relative error is small for all arcs. The plain expression θ/sin θ − 1 loses all digits for short ones."""
    theta = mp.radians(mp.mpf(degrees))
    with mp.workdps(300):
        exact = theta / mp.sin(theta) - 1
        square, cosine = float(mp.sin(theta) ** 2), float(mp.cos(theta))
    assert angle_over_sine(np.array([square]), np.array([cosine]))[0] == pytest.approx(float(exact), rel=2e-15, abs=0.0)
    naive = np.arctan2(math.sqrt(square), cosine) / math.sqrt(square) - 1.0
    assert degrees >= 1.0 or naive != pytest.approx(float(exact), rel=1e-8, abs=0.0)


@pytest.mark.parametrize("power", [0.0, 0.7, 30.0, 1e4])
@pytest.mark.parametrize("cosine", [0.9, 0.1, -0.3])
def test_a_polygon_with_a_bay_is_its_parts(power, cosine):
    """A concave arrow of two triangles, also where the horizon cuts it into two parts."""
    tip, left, bay, right = (np.array(x, float) for x in ([0, 1, 0], [-1, -1, 0], [0, -0.2, 0], [1, -1, 0]))
    middle, n = np.array([0.2, 0.1, -0.9]), np.array([0.1, math.sqrt(1 - cosine**2), -cosine])
    n, w = unit(n), unit(np.array([0.3, 0.3, -1.0]))
    for form in (CosinePower("mirror", power), CosinePower("normal", 1.0)):
        axis = w if form.around == "mirror" else n
        halves = [[tip, left, bay], [tip, bay, right]]
        sums = [of_polygon(form, axis, n, middle, x) * np.linalg.norm(vector_area(x)) for x in halves]
        arrow = [tip, left, bay, right]
        got = of_polygon(form, axis, n, middle, arrow) * np.linalg.norm(vector_area(arrow))
        assert got == pytest.approx(sum(sums), rel=1e-9, abs=1e-12)


def test_repeated_and_collinear_corners_change_nothing():
    square = [np.array(x, float) for x in ([-1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0])]
    more = [square[0], square[0], square[1], np.array([0.0, 1, 0]), np.array([1e-14, 1, 0]), *square[2:]]
    middle, w = np.array([0.3, 0.2, -1.5]), unit(np.array([0.1, 0.0, -1.0]))
    for n in (np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])):
        for form in (CosinePower("normal", 1.0), CosinePower("mirror", 50.0)):
            axis = w if form.around == "mirror" else n
            a, b = (of_polygon(form, axis, n, middle, x) for x in (square, more))
            assert b == pytest.approx(a, rel=1e-12)


@pytest.mark.parametrize("power", [0.3, 3.0, 20.0])
def test_of_a_light_around_what_is_opposite_to_the_lobe_there_is_what_is_in_front(power):
    middle, n, w = np.array([0.0, 0.2, -0.15]), np.array([0.0, 0.0, -1.0]), unit(np.array([0.3, -0.2, 0.25]))
    square = [np.array(x, float) for x in ([-1, -1, 0], [-1, 1, 0], [1, 1, 0], [1, -1, 0])]
    exact = exact_of_polygon(w, power, n, middle, square[::-1])
    assert of_polygon(CosinePower("mirror", power), w, n, middle, square) == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("form", [CosinePower("normal", 1.0), CosinePower("mirror", 20.0)])
def test_the_back_of_a_light_is_dark_unless_it_glows_too(form):
    corners = np.ravel([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]).tolist()
    ahead = np.array([0.3, 0.1, -1.0])
    lights = {
        (polygon_irradiance, polygon_highlight): (2.0, math.sqrt(2.0), 4.0, *corners),
        (disk_irradiance, disk_highlight): (0.7,),
    }
    for formulas, shape in lights.items():
        n = ahead / np.linalg.norm(ahead)
        seen = {
            (two_sided, side): float(
                taken(formulas, form, [0, 0, 1, two_sided, *shape], side * ahead, side * n, side * n)[0]
            )
            for two_sided in (0.0, 1.0)
            for side in (1.0, -1.0)
        }
        assert seen[0.0, -1.0] == 0.0 < seen[0.0, 1.0]
        assert seen[1.0, -1.0] == pytest.approx(seen[1.0, 1.0], rel=1e-12)
        assert seen[0.0, 1.0] == seen[1.0, 1.0]


def on_disk(form, axis, n, middle, facing, radius=1.0):
    return float(taken((disk_irradiance, disk_highlight), form, [*facing, 1.0, radius], middle, n, axis)[0])


def exact_of_disk(axis, power, n, middle, facing):
    with mp.workdps(15 if np.linalg.norm(middle) < 10.0 else 30):
        axis, n, facing = (oracle.unit(oracle.exact_vector(x)) for x in (axis, n, facing))
        return float(oracle.power_over_disk(axis, power, n, oracle.exact_vector(middle), facing, mp.mpf(1)) / mp.pi)


def around_a_disk(facing, across):
    """Return the corners of a polygon with the same area as a disk."""
    x = 2 * math.pi / 200
    other, size = np.cross(facing, across), math.sqrt(x / math.sin(x))
    return [size * (math.cos(k * x) * across + math.sin(k * x) * other) for k in range(200)]


AS_DISKS = [("normal", 1.0, *case[1:]) for case in CASES[:8]] + [("mirror", *case) for case in CASES]


@pytest.mark.parametrize(("around", "power", "distance", "is_cut"), AS_DISKS)
def test_a_power_over_a_disk(around, power, distance, is_cut):
    _, facing, across, middle, n, w = thrown(power, distance, is_cut)
    form, axis = CosinePower(around, power), n if around == "normal" else w
    got = on_disk(form, axis, n, middle, facing) * distance**2
    assert on_disk(form, axis, n, middle, -facing) * distance**2 == pytest.approx(got, abs=1e-13)
    if distance > 1.0:
        exact, off = exact_of_disk(axis, power, n, middle, facing), 1e-9 + is_cut * 1e-14 * distance
    else:  # the oracle has too few nodes close to the rim
        exact, off = of_polygon(form, axis, n, middle, around_a_disk(facing, across)), 1e-5
    assert got == pytest.approx(exact * distance**2, abs=off)


@pytest.mark.parametrize("size", [1.0, 1e-4])
@pytest.mark.parametrize("tilt", [0.0, 1e-17, 1e-15, 1e-12, 1e-6])
def test_a_disk_that_faces_the_vertex_has_no_direction_of_its_own(size, tilt):
    middle = np.array([0.3, -0.2, 1.0])
    facing, w = unit(middle + tilt * np.array([1.0, 0.0, 0.0])), unit(np.array([0.31, -0.2, 1.0]))
    n = np.array([0.0, 0.0, 1.0])
    for form in (CosinePower("mirror", 20.0), CosinePower("normal", 1.0)):
        axis = w if form.around == "mirror" else n
        across = unit(np.cross(facing, [0.0, 1.0, 0.0]))
        got = on_disk(form, axis, n, middle, -facing, size)
        offsets = [size * x for x in around_a_disk(facing, across)]
        assert got == pytest.approx(of_polygon(form, axis, n, middle, offsets), rel=1e-7)


@pytest.mark.parametrize("power", [0.0, 0.5, 3.0, 50.0, 1e4, 1e6])
@pytest.mark.parametrize("aside", [-1.0, 0.0, 1.0, 1.000001, 4.0])
def test_a_lobe_that_goes_to_the_middle_an_edge_beside_it_or_far_off(power, aside):
    middle, n, form = np.array([0.0, 0.0, 4.0]), np.array([0.0, 0.0, 1.0]), CosinePower("mirror", power)
    w, square = unit(np.array([aside, 0.0, 4.0])), [np.array(x, float) for x in product((-1, 1), (-1, 1), [0])]
    square = [square[k] for k in (0, 1, 3, 2)]
    exact = exact_of_polygon(w, power, n, middle, square)
    assert of_polygon(form, w, n, middle, square) == pytest.approx(exact, abs=1e-10)
    assert on_disk(form, w, n, middle, -n) == pytest.approx(exact_of_disk(w, power, n, middle, -n), abs=1e-10)


# --- spherical caps: spheres as seen from a vertex

CAP_POWERS = (0.0, 0.3, 1.0, 2.5, 20.0, 100.7, 1e3, 1e6)
SINES = (1e-9, 1e-6, 1e-4, 0.01, 0.3, 0.9, 0.9999)


def aside(random, axis, angle):
    """Return a random unit vector at an angle from an axis."""
    across = np.cross(axis, random.normal(size=3))
    return math.cos(angle) * axis + math.sin(angle) * across / np.linalg.norm(across)


def thrown_at_a_cap(power, sine, is_cut, seed=0):
    """Return the axis w near the cap, the normal, and the cap's axis."""
    random = np.random.default_rng([int(10 * power), int(-math.log(sine) * 100), is_cut, seed])
    l = unit(random.normal(size=3))
    tilt = math.pi / 2 + random.uniform(-0.95, 0.95) * math.asin(sine) if is_cut else random.uniform(0, 0.99)
    n = aside(random, l, tilt if is_cut else tilt * (math.pi / 2 - math.asin(sine)))
    w = aside(random, l, random.uniform(0.0, 1.2) * (math.asin(sine) + 1.0 / math.sqrt(power + 1.0)))
    return w, n, l


def of_cap(w, n, l, sine, power, around="mirror"):
    return float(taken((sphere_irradiance, sphere_highlight), CosinePower(around, power), [sine], l, n, w)[0])


def exact_of_cap(w, n, l, sine, power):
    with mp.workdps(30):
        w, n, l = (oracle.unit(oracle.exact_vector(x)) for x in (w, n, l))
        edge = mp.sqrt(1 - mp.mpf(sine) ** 2)
        return float(oracle.power_over(w, power, [(n, mp.mpf(0)), (l, edge)]) / (mp.pi * mp.mpf(sine) ** 2))


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize("sine", SINES)
@pytest.mark.parametrize("power", CAP_POWERS)
def test_a_power_over_a_cap(power, sine, is_cut):
    w, n, l = thrown_at_a_cap(power, sine, is_cut)
    # the horizon's position in the cap depends on the rounding of n·l
    off = 1e-9 + is_cut * 2.0**-52 / sine
    assert of_cap(w, n, l, sine, power) == pytest.approx(exact_of_cap(w, n, l, sine, power), abs=off)


@pytest.mark.parametrize("is_cut", [False, True])
@pytest.mark.parametrize("sine", SINES)
def test_lamberts_cosine_over_a_cap(sine, is_cut):
    _, n, l = thrown_at_a_cap(1.0, sine, is_cut)
    got = of_cap(n, n, l, sine, 1.0, "normal")
    assert got == pytest.approx(exact_of_cap(n, n, l, sine, 1.0), rel=1e-9 if sine > 1e-8 else 1e-6)
    assert got == pytest.approx(of_cap(n, n, l, sine, 1.0), abs=1e-9)
