"""Layers of the package: modules import only from lower layers, and the core imports neither PyVista nor VTK."""

import ast
import inspect
import json
import re
import tomllib
import traceback
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
import pyvista as pv
from apart import run_apart

import pvphong
import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES
from pvphong.optics.reflectances import Phong

FLOORS = (
    {"base"},
    {"geometry"},
    {"optics"},
    {"scene"},
    {"shading"},
    {"rays"},
    {"meshes"},
    {"vtk", "batch"},
    {"studies.validate", "studies.diagnose", "studies.refine", "studies.fitting"},
    {"studies.accuracy"},
    {"studio"},
    {"accessor", "plotter", "filter", "chunks", "pipeline", "report", "cli"},
    {"__init__", "__main__"},
)
"""Packages, and the modules next to them, from the lowest layer up; a package's `__init__` belongs to it."""

PACKAGE = Path(pvphong.__file__).parent
CORE = 4
"""The floors from base to shading."""

LIGHTS = {kind.__name__ for kind in LIGHT_TYPES.values()}

HOSTS = ("pyvista", "vtk", "vtkmodules")


def name_of(path):
    """Return a module's name: `lights.spot`, `lights` for a package, `__init__` for pvphong itself."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(parts[:-1] if len(parts) > 1 and parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in sorted(PACKAGE.rglob("*.py"))}


def room_of(module):
    """Return the entry of `FLOORS` that a module is in, or None."""
    rooms = [room for floor in FLOORS for room in floor if f"{module}.".startswith(f"{room}.")]
    return rooms[0] if rooms else None


def floor_of(module):
    """Return a module's layer, counted from below. Namespace packages such as `studies` have none."""
    room = room_of(module)
    return next((floor for floor, rooms in enumerate(FLOORS) if room in rooms), -1)


@cache
def imports_of(module, *, types=True):
    """Return the names that a module imports anywhere; without `types`, only the imports at run time."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    nodes = set(ast.walk(tree))
    for node in ast.walk(tree):
        if not types and isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            nodes -= {inner for child in node.body for inner in ast.walk(child)}
    found = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module} imports relatively; write the package's name"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def own_imports(module):
    """Return pvphong's modules that a module imports anywhere, types included, or loads by their names.

    Importing a module runs `__init__` of its packages: these count as imported by modules outside of them.
    """
    found = set()
    for name in imports_of(module):
        if name.split(".")[0] != "pvphong":
            continue
        inner = name.removeprefix("pvphong").lstrip(".")
        while inner and inner not in MODULES:  # a name inside of a module
            inner = inner.rpartition(".")[0]
        found.add(inner or "__init__")
        while inner := inner.rpartition(".")[0]:
            if inner in MODULES and not f"{module}.".startswith(f"{inner}."):
                found.add(inner)
    return found - {module}


def test_there_is_something_to_test():
    assert {"optics.lights.spot", "scene.scene", "shading.evaluation", "meshes.lit", "__init__"} <= set(MODULES)
    assert own_imports("scene.scene") >= {"base.check", "optics.lights", "scene.viewer", "base.files"}
    assert floor_of("optics.lights.spot") == floor_of("optics") == 2
    assert floor_of("studies") == -1


def test_every_module_has_a_floor():
    homeless = [module for module in MODULES if floor_of(module) < 0 and own_imports(module)]
    assert not homeless, "put them into a package of the table above"


PACKAGES = sorted({path.parent for path in MODULES.values() if path.parent != PACKAGE})


def test_a_package_says_what_is_in_it():
    """A package's docstring names its modules in reading order. For lights and reflectances, a table does."""
    for folder in PACKAGES:
        text = (folder / "__init__.py").read_text(encoding="utf-8")
        inside = [path.stem for path in folder.glob("*.py") if path.stem != "__init__"]
        inside += [path.parent.name for path in folder.glob("*/__init__.py")]
        assert not [name for name in inside if not re.search(rf"\b{name}\b", text)], folder


def test_no_file_is_longer_than_can_be_read_in_one_go():
    lengths = {module: len(path.read_text(encoding="utf-8").splitlines()) for module, path in MODULES.items()}
    assert not {module: length for module, length in lengths.items() if length > 700}


def test_imports_point_downward():
    """Modules import from lower layers, or from their own package."""
    for module in MODULES:
        here, room = floor_of(module), room_of(module)
        found = {name: floor_of(name) for name in own_imports(module) if room_of(name) != room}
        assert not {name for name, floor in found.items() if floor >= here}, f"{module} is on floor {here}"


def test_no_module_takes_private_names_of_another():
    for module in MODULES:
        parted = (name.removeprefix("pvphong.") for name in imports_of(module))
        taken = (name.rpartition(".") for name in parted if name not in MODULES)
        private = [f"{owner}.{name}" for owner, _, name in taken if owner in MODULES and name.startswith("_")]
        assert not private, module


def test_imports_do_not_run_in_circles():
    try:
        order = list(TopologicalSorter({module: own_imports(module) for module in MODULES}).static_order())
    except CycleError as error:
        pytest.fail(f"imports run in a circle: {' → '.join(error.args[1])}")
    assert len(order) == len(MODULES)


CORE_MODULES = [module for module in MODULES if 0 <= floor_of(module) <= CORE]


def test_the_core_imports_no_host():
    for module in CORE_MODULES:
        hosts = {name for name in imports_of(module, types=False) if name.split(".")[0].startswith(HOSTS)}
        assert not hosts, f"{module} is on floor {floor_of(module)}; ask `base.host` instead"


LOAD_CORE = """
import importlib, json, sys, types

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {hosts}:
            raise ImportError(f"the core imported {{name}}")

sys.meta_path.insert(0, Blocked())
package = types.ModuleType("pvphong")  # without running its __init__
package.__path__ = [{path!r}]
sys.modules["pvphong"] = package
for name in {names}:
    importlib.import_module("pvphong." + name)
from pvphong.shading.evaluation import evaluate
from pvphong.optics.lights import PointLight
from pvphong.optics.material import Material
from pvphong.scene.scene import Scene
rgb = evaluate([[0.0, 0, 0]], [[0.0, 0, 1]], Scene([PointLight((0, 0, 2))]), Material()).rgb
assert abs(rgb[0, 0] - 0.84) < 1e-6
print(json.dumps(sorted(name for name in sys.modules if name.split(".")[0] in {hosts})))
"""


def test_the_core_lights_without_pyvista_and_vtk():
    assert json.loads(run_apart(LOAD_CORE.format(hosts=HOSTS, path=str(PACKAGE), names=CORE_MODULES))) == []


NEW_MODULES = """
import json, sys
import pyvista
before = set(sys.modules)
import pvphong
pvphong.evaluate
print(json.dumps(sorted(set(sys.modules) - before)))
"""


def test_importing_pvphong_loads_nothing_heavy_beside_pyvista():
    new = json.loads(run_apart(NEW_MODULES))
    assert "pvphong.shading.evaluation" in new
    heavy = {"dask", "distributed", "matplotlib", "numba", "llvmlite", "rich", "cyclopts", "scipy", "PIL"}
    assert not [name for name in new if name.split(".")[0] in heavy]


def test_no_module_hides_a_public_function():
    functions = {name for name in pvphong.__all__ if inspect.isfunction(getattr(pvphong, name))}
    assert "evaluate" in functions
    assert not functions & {module.split(".")[0] for module in MODULES}


def test_the_face_says_what_it_gives():
    assert sorted(pvphong.__all__) == sorted(set(pvphong.__all__))
    for face in (pvphong, pvphong.pipeline):
        undocumented = [name for name in face.__all__ if not (getattr(face, name).__doc__ or "").strip()]
        assert not undocumented


def test_a_public_name_is_in_one_place():
    """The docstring of `pipeline` lists all of its names."""
    pipeline = pvphong.pipeline
    assert not [name for name in pipeline.__all__ if hasattr(pvphong, name)]
    assert set(re.findall(r"`(\w+)`", pipeline.__doc__)) == set(pipeline.__all__)


def test_few_modules_know_a_light_by_its_class():
    """Code calls methods of lights. Only modules that create lights, and the plan's table, name the classes."""

    def makes(module):
        tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
        own = {node.name for node in tree.body if isinstance(node, ast.ClassDef)}
        named = {getattr(node, "id", getattr(node, "attr", None)) for node in ast.walk(tree)}
        named |= {name.rpartition(".")[2] for name in imports_of(module)}
        return named & LIGHTS - own

    outside = {module for module in MODULES if makes(module) and not f"{module}.".startswith("optics.lights.")}
    made = {
        "__init__",
        "cli.demo",
        "cli.options",
        "scene.daylight",
        "scene.presets",
        "shading.interreflection",
        "shading.plan.lights",
        "studies.validate.cases",
        "studio.gizmos.commands",
    }
    assert outside == made


def test_a_light_is_asked_what_it_can_do_and_not_what_it_is():
    """`isinstance` of a light appears only in VTK's readers and in four checks that an argument is a light."""
    found = [
        module
        for module in MODULES
        if not module.startswith("vtk.")
        for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in {"isinstance", "issubclass"}
        if {getattr(part, "id", "") for part in ast.walk(node.args[1])} & {"Light", *LIGHTS}
    ]
    assert found
    assert len(found) <= 4


def test_what_is_said_to_be_installed_is_a_package_that_the_project_asks_for():
    root = Path(pvphong.__file__).parents[1]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    known = {re.split(r"[>=<\[]", each)[0] for requirements in groups for each in requirements}
    said = [
        hint
        for folder in ("pvphong", "examples")
        for path in (root / folder).rglob("*.py")
        for hint in re.findall(r"pip install ((?:[\w-]+ )*?[\w-]+)(?= installs| makes|[.\"'])", path.read_text("utf-8"))
    ]
    assert len(said) >= 6
    assert all(package in known for hint in said for package in hint.split())


def test_the_walk_to_a_formula_is_short(monkeypatch):
    """Count pvphong's frames and files from a call down to Phong's formula in NumPy."""
    walks, factors = [], Phong.factors

    def noted(*given):
        frames = [frame for frame in traceback.extract_stack()[:-1] if Path(frame.filename).is_relative_to(PACKAGE)]
        walks.append((len(frames) + 1, len({frame.filename for frame in frames} | {inspect.getfile(factors)})))
        return factors(*given)

    monkeypatch.setattr(Phong, "factors", staticmethod(noted))
    shiny = ph.Material(specular=1.0, reflectance=Phong(20.0))
    pv.Sphere().phong.shade(ph.DirectionalLight(), shiny, backend="numpy")
    assert walks == [(7, 5)]
