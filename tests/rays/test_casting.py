"""All backends match exact geometry, in any unit and anywhere, and tolerate broken meshes."""

from contextlib import nullcontext

import numpy as np
import pytest
import pyvista as pv
from ray_backends import BACKENDS

import pvphong as ph
from pvphong.meshes import truth
from pvphong.rays import casting, transport, visibility
from pvphong.rays.casting import BlockingFaces, Occluders


@pytest.fixture(params=BACKENDS, autouse=True)
def backend(request, monkeypatch):
    monkeypatch.setattr(casting, "ray_backend", lambda: (BACKENDS[request.param], ""))
    return request.param


def caster(triangles):
    return Occluders([BlockingFaces(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3))])


def ball():
    mesh = pv.Sphere(theta_resolution=12, phi_resolution=12)
    return mesh.points[mesh.faces.reshape(-1, 4)[:, 1:]].astype(np.float64)


def rays(count=2000, seed=3):
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return random.uniform(-1, 1, size=(count, 3)), directions, random.uniform(0, 2, count)


def met(triangles, origins, directions, distances):
    """Return first hits by Möller and Trumbore's formula, and the margins of rays from edges and ends."""
    a, b, c = triangles.transpose(1, 0, 2)
    across = np.cross(directions[:, None], c - a)
    det = (across * (b - a)).sum(axis=2)
    to = origins[:, None] - a
    u = (to * across).sum(axis=2) / det
    q = np.cross(to, b - a)
    v = (directions[:, None] * q).sum(axis=2) / det
    t = (q * (c - a)).sum(axis=2) / det
    margin = np.minimum.reduce([u, v, 1 - u - v, t, distances[:, None] - t])
    return margin.max(axis=1) > 0.0, np.abs(margin).min(axis=1)


def test_rays_meet_what_exact_geometry_says(monkeypatch):
    monkeypatch.setattr(casting, "_RAYS_AT_ONCE", 300)
    triangles, given = ball(), rays()
    expected, margin = met(triangles, *given)
    clear = margin > 1e-5
    assert clear.mean() > 0.9
    assert 0.1 < expected.mean() < 0.9
    np.testing.assert_array_equal(caster(triangles).blocked(*given)[clear], expected[clear])


@pytest.mark.parametrize(("offset", "away"), [(0.0, 0.0), (1e5, 0.0), (0.0, 1e3)])
def test_what_is_met_first_is_where_the_ray_comes_to(monkeypatch, offset, away):
    """A ball in a much larger one, which has its own caster, with invalid triangles added."""
    monkeypatch.setattr(casting, "_RAYS_AT_ONCE", 700)
    triangles, (origins, directions, distances) = ball(), rays()
    origins, distances = 0.9 * origins + offset - away * directions, np.where(distances > 1.0, np.inf, distances + away)
    spoiled = np.full((3, 3, 3), np.nan)
    parts = [np.concatenate([spoiled, triangles + offset]), np.concatenate([triangles * 1e3 + offset, spoiled])]
    parts = [BlockingFaces(part.reshape(-1, 3), np.arange(3 * len(part)).reshape(-1, 3)) for part in parts]
    occluders = Occluders(parts)
    hits, all_triangles = occluders.first(origins, directions, distances), np.concatenate([p.points for p in parts])
    np.testing.assert_array_equal(occluders.points, all_triangles)
    met, others = hits.triangles >= 0, hits.weights.astype(np.float64)
    weights = np.column_stack([1.0 - others.sum(axis=1), others])[met]
    corners = all_triangles[occluders.triangles.corners[hits.triangles[met]]]
    place = (weights[:, :, None] * corners).sum(axis=1)
    expected = (origins + hits.distances[:, None] * directions)[met]
    size = np.where(hits.triangles[met] < len(parts[0]), 1.0, 1e3)
    assert (np.abs(place - expected).max(axis=1) < 1e-6 * size + 1e-10 * (offset + away)).all()
    assert (weights > -1e-5).all()
    assert (hits.triangles[met] >= 3).all()
    assert np.isinf(hits.distances[~met]).all()
    # nothing is closer: the rays are not blocked before their hits
    margin = 1e-2 * np.where(hits.triangles < len(parts[0]), 1.0, 30.0)
    before = np.where(met, hits.distances - margin, distances)
    assert not occluders.blocked(origins, directions, before)[before > away + margin].any()
    assert occluders.blocked(origins, directions, hits.distances + margin)[met & (hits.distances > away)].all()
    assert 0.2 < met.mean() <= 1.0


def test_one_kind_casts_all_rays_though_another_is_there_before_the_last_caster_is_built(backend, monkeypatch):
    kinds = iter([BACKENDS[backend], *(kind for kind in BACKENDS.values() if kind is not BACKENDS[backend])])
    monkeypatch.setattr(casting, "ray_backend", lambda: (next(kinds), ""))
    small = 1e-3 * ball() + 5.0
    both = Occluders([caster(triangles).parts[0] for triangles in (ball(), small)])
    towards = np.array([[5.0, 5.0, 5.0], [-1.0, -1.0, -1.0]]) / np.sqrt([[75.0], [3.0]])
    hits = both.first(np.ones((2, 3)), towards, np.full(2, np.inf))
    assert len(both.casters) == 2
    assert {type(each.backend) for each in both.casters} == {BACKENDS[backend]}
    np.testing.assert_allclose(hits.distances, [np.sqrt(48.0), np.sqrt(3.0) - 0.5], atol=0.02)  # a coarse ball


@pytest.mark.parametrize("exponent", [-1000, -120, 40, 1000])
def test_the_unit_of_length_changes_nothing(exponent):
    origins, directions, distances = rays(300)
    expected = caster(ball()).blocked(origins, directions, distances)
    scaled = caster(np.ldexp(ball(), exponent))
    found = scaled.blocked(np.ldexp(origins, exponent), directions, np.ldexp(distances, exponent))
    np.testing.assert_array_equal(found, expected)
    assert scaled.resolution(None) == np.ldexp(caster(ball()).resolution(None), exponent)


@pytest.mark.parametrize("offset", [0.0, 1e4, -1e7, 1e9])
@pytest.mark.parametrize("away", [0.0, 10.0, 1e5, 1e12])
def test_nor_do_a_place_far_from_the_origin_and_rays_from_far_away(offset, away):
    triangles, (origins, directions, _) = ball(), rays(300)
    infinite, origins = np.full(300, np.inf), origins - 4.0 * directions
    expected, margin = met(triangles, origins, directions, infinite)
    clear = margin > max(1e-5, 1e-14 * away)
    assert expected[clear].any()
    moved, far = caster(triangles + offset), origins + offset - away * directions
    np.testing.assert_array_equal(moved.blocked(far, directions, infinite)[clear], expected[clear])
    assert not moved.blocked(far, directions, np.full(300, away)).any()


def test_spoiled_triangles_and_rays_meet_nothing_and_harm_no_other():
    for triangles in (np.zeros((0, 3, 3)), np.zeros((4, 3, 3)), np.full((2, 3, 3), np.nan)):
        assert not caster(triangles).blocked(*rays(10)).any()
    triangles, given = ball(), rays(300)
    spoiled = np.repeat(triangles[:4], 2, axis=0)
    spoiled[0, 1, 2], spoiled[1, 0], spoiled[2, 2, 0] = np.nan, np.inf, -np.inf
    spoiled[3:6, 2] = spoiled[3:6, 0]
    spoiled[6:, 2] = (spoiled[6:, 0] + spoiled[6:, 1]) / 2
    spoiled = caster(np.concatenate([spoiled, triangles]))
    expected = caster(triangles).blocked(*given)
    np.testing.assert_array_equal(spoiled.blocked(*given), expected)
    origins, directions, distances = given
    origins[3], origins[5, 1], directions[7], distances[9] = np.nan, np.inf, np.nan, np.nan
    distances[11], directions[13] = -1.0, 0.0
    found = spoiled.blocked(origins, directions, distances)
    assert not found[[3, 5, 7, 9, 11, 13]].any()
    sound = np.setdiff1d(np.arange(300), [3, 5, 7, 9, 11, 13])
    np.testing.assert_array_equal(found[sound], expected[sound])


CASTING = {
    "visibility": lambda mesh: mesh.phong.visibility([ph.DirectionalLight()]).per_light,
    "transport": lambda mesh: mesh.phong.transport(samples=16).gather(np.ones((mesh.n_points, 1))),
    "truth": lambda mesh: mesh.phong.truth([ph.PointLight((0, 0, 9))], samples=16),
}


@pytest.mark.parametrize("cast", CASTING.values(), ids=CASTING)
def test_without_embree_it_is_said_once_and_only_where_it_matters(monkeypatch, backend, cast):
    """Warnings are errors in tests, so an unexpected one fails."""
    casting.warn_of_slow_rays.cache_clear()
    few, many = (pv.merge([pv.Cube(), pv.Plane(i_resolution=cells)]) for cells in (1, 10))
    for module, name in ((visibility, 100), (transport, 100), (truth, 100 * 16)):
        monkeypatch.setattr(module, "_WORTH_A_WARNING", name)
    cast(few)
    with pytest.warns(casting.SlowRaysWarning, match="pip install embreex") if backend == "vtk" else nullcontext():
        cast(many)
    cast(many)


def test_more_triangles_than_fit_into_memory_are_refused_before_any_is_read(monkeypatch):
    monkeypatch.setattr(casting, "available_memory", lambda: 10**9)
    many = BlockingFaces(np.zeros((3, 3)), np.broadcast_to(np.arange(3), (10**7, 3)))
    with pytest.raises(ValueError, match=r"^occluders must be small enough for the 1 GB.*10,000,000.*1\.3 GB.*decim"):
        Occluders([many]).casters  # noqa: B018
