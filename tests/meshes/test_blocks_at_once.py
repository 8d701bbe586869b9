"""Small blocks that are lit at once: each has the same bits as if it is lit alone."""

import copy

import numpy as np
import pytest
import pyvista as pv

import pvphong as ph
from pvphong import DirectionalLight, LightModel, Material, PointLight, RectangleLight, Scene, SpotLight, Viewer
from pvphong.meshes import lit
from pvphong.meshes.blocks import leaves
from pvphong.shading import kernel

EYE = Viewer(position=(1, 2, 6))
LAMPS = [
    DirectionalLight(direction=(-1, 0.5, -1), diffuse=(0.9, 0.8, 0.7), name="sun"),
    PointLight(position=(2, -1, 3), attenuation=(0.5, 0.1, 0.02), ambient=0.05),
    SpotLight(position=(0, 4, 1), direction=(0, -1, 0), cone_angle=15, exponent=3, name="spot"),
]
SOFTBOX = RectangleLight(position=(3, 0, 2), direction=(-1, 0, -1), width=1.0, height=2.0)
SHINY = Material(ambient=0.1, diffuse=(0.7, 0.6, 0.5), specular=0.4, shininess=12)
STRETCHED = np.array([[1, 0.5, 0, 3], [0, 2, 0.1, 1], [0.2, 0, 1, -1], [0, 0, 0, 1]], float)
SCENES = {
    "lamps": Scene(LAMPS, viewer=EYE),
    "two-sided": Scene(LAMPS, viewer=EYE, light_model=LightModel(two_sided=True)),
    "softbox": Scene([SOFTBOX, LAMPS[0]], viewer=EYE, light_model=LightModel(clamp=False)),
    "a sky alone": Scene([], viewer=EYE, light_model=LightModel(ambient=0.3)),
    "shadows": Scene(LAMPS[:2], viewer=EYE, light_model=LightModel(shadows=True, ambient_occlusion=True)),
    "bounces": Scene(LAMPS[:2], viewer=EYE, light_model=LightModel(bounces=1)),
}
BACKENDS = ["auto", "numpy", *(["numba"] if kernel.is_available() else [])]


def many():
    """Return blocks that differ in their normals, the type of their points, defects and positions."""
    ball = pv.Sphere(theta_resolution=9, phi_resolution=8)
    bare = ball.copy()
    bare.clear_data()
    exact = ball.copy()
    exact.points = ball.points + np.array([0.1, 0.0, 1e6])
    odd = bare.copy()
    odd.points = np.vstack([ball.points, [(np.nan, 0, 0), (9, 9, 9)]])  # without faces
    odd.faces = np.hstack([ball.faces, [3, 0, 0, 1], [3, 2, 3, 4], [3, 4, 3, 2]])
    fine = pv.Sphere(theta_resolution=200, phi_resolution=180)
    cloud = pv.PolyData(np.eye(3, dtype=np.float32))
    cloud.point_data.active_normals = np.array([[0, 0, 1.0], [0, 0, 0], [np.inf, 0, 1]])
    inner = pv.MultiBlock({"bare": bare, "plane": pv.Plane(i_resolution=3), "far": ball.translate((0, 0, 50))})
    given = {"ball": ball, "gap": None, "exact": exact, "odd": odd, "fine": fine, "in": inner}
    given |= {"grid": pv.ImageData(dimensions=(4, 3, 3)), "cloud": cloud, "empty": pv.PolyData()}
    given |= {f"{k}": pv.Cube(center=(k, 0, 0)).triangulate() for k in range(5)}
    return pv.MultiBlock(given)


def assert_same_bits(found, expected):
    assert found == expected
    for name in expected.point_data:
        one, other = (np.asarray(each.point_data[name]) for each in (found, expected))
        assert (one.dtype, one.tobytes()) == (other.dtype, other.tobytes()), name


@pytest.mark.filterwarnings("ignore::pvphong.NormalsWarning")
@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scene", ["lamps", "two-sided", "softbox", "a sky alone"])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"components": True, "precision": "float64"},
        {"matrix": STRETCHED, "feature_angle": 30, "name": "lit"},
        {"tolerance": 0.02},
    ],
)
def test_each_block_has_the_bits_that_it_has_by_itself(scene, options, backend):
    blocks, scene = many(), SCENES[scene]
    before = copy.deepcopy(blocks)
    found = blocks.phong.shade(scene, SHINY, backend=backend, **options)
    assert (found.keys(), found["in"].keys(), found["gap"]) == (blocks.keys(), blocks["in"].keys(), None)
    for one, block in zip(leaves(found), leaves(blocks), strict=True):
        assert_same_bits(one, block.phong.shade(scene, SHINY, backend=backend, **options))
        colors = np.asarray(one[options.get("name", "phong")])
        assert one.n_points > 30_000 or colors.base.nbytes <= colors.nbytes  # not a view of the colours of all blocks
    assert blocks == before


@pytest.mark.parametrize("shadows", [True, False])
@pytest.mark.parametrize("kind", ["maps", "colormap", "tangents", "named materials", "texture"])
def test_blocks_that_are_not_alike_have_them_too(kind, shadows):
    blocks = pv.MultiBlock([pv.Plane(i_resolution=3, center=(k, 0, 0)) for k in range(3)])
    for k, block in enumerate(blocks):
        block["tint"] = np.linspace(0.1 * k, 1.0, 3 * block.n_points).reshape(-1, 3)
        block["grain"] = np.tile([1.0, k, 0.0], (block.n_points, 1))
        block["heat"] = np.linspace(0.0, k + 1.0, block.n_points)
    texture = pv.Texture(np.arange(48, dtype=np.uint8).reshape(4, 4, 3) * 5)
    material = {
        "maps": Material(albedo="tint"),
        "colormap": Material(albedo=ph.Colormap("heat", clim=(0, 3))),
        "tangents": Material(specular=0.5, reflectance=ph.Ward(0.2, 0.4), tangents="grain"),
        "named materials": {"default": SHINY, "Block-01": Material(diffuse=0.2), "Block-02": SHINY},
        "texture": Material(albedo=texture),
    }[kind]
    scene = SCENES["shadows" if shadows else "lamps"]
    found = blocks.phong.shade(scene, material, components=True)
    own = material if isinstance(material, dict) else {"default": material}
    for k, name in enumerate(blocks.keys()):
        others = [block for block in blocks if block is not blocks[k]]
        given = {"occluders": others} if shadows else {}
        alone = blocks[k].phong.shade(scene, own.get(name, own["default"]), components=True, **given)
        for array in alone.point_data:
            np.testing.assert_allclose(found[k][array], alone[array], atol=1e-6 if shadows else 0.0)


def test_there_is_one_plan_for_all_that_are_alike(monkeypatch):
    planned, run = [], []
    of, run_plan = lit.Plan.of, lit.Plan.run
    monkeypatch.setattr(lit.Plan, "of", lambda *given, **how: planned.append(len(given[2])) or of(*given, **how))
    monkeypatch.setattr(lit.Plan, "run", lambda *given, **how: run.append(len(given[1])) or run_plan(*given, **how))
    ball, matte = pv.Sphere(theta_resolution=5, phi_resolution=5), Material(diffuse=0.2)
    blocks = pv.MultiBlock({f"{k}": ball for k in range(20)})
    blocks.phong.shade(SCENES["lamps"], {"default": SHINY, "3": matte, "7": matte})
    assert planned == run == [18 * ball.n_points, 2 * ball.n_points]


@pytest.mark.parametrize("scene", ["lamps", "bounces"])
def test_a_backend_goes_for_the_normals_of_blocks_too(scene, monkeypatch):
    asked = []
    normals = lit.point_normals
    monkeypatch.setattr(lit, "point_normals", lambda *given, backend: asked.append(backend) or normals(*given))
    pv.MultiBlock([pv.Cube()]).phong.shade(SCENES[scene], backend="numpy")
    assert set(asked) >= {"numpy"}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"name": "Normals"}, r"^block \['a'\]: name must be"),
        ({"tolerance": -1.0}, r"^block \['a'\]: tolerance must be"),
        ({"precision": "float16"}, r"^block \['a'\]: precision must be"),
        ({"backend": "fortran"}, r"^block \['a'\]: backend must be"),
        ({"matrix": np.zeros((4, 4))}, r"^block \['a'\]: matrix must be"),
        ({"shares_by_bounce": True}, r"^block \['a'\]: shares_by_bounce must be"),
        ({"feature_angle": 200}, r"^block \['a'\]: feature_angle must be"),
    ],
)
def test_what_is_wrong_is_refused_at_the_first_block(options, message):
    ball = pv.Sphere()
    with pytest.raises(ValueError, match=message):
        pv.MultiBlock({"a": ball, "b": ball}).phong.shade(SCENES["lamps"], SHINY, **options)


def test_a_block_among_many_that_cannot_be_lit_is_named():
    blocks = pv.MultiBlock({"a": pv.Sphere(), "in": pv.MultiBlock({"b": pv.PolyData(np.eye(3))})})
    with pytest.raises(ValueError, match=r"^block \['in'\]\['b'\]: mesh must be"):
        blocks.phong.shade(SCENES["lamps"])
