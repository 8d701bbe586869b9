"""Compiled code is kept on disk if possible, and works without if not."""

from __future__ import annotations

import os
import shutil
import sys

import pytest
from apart import EVALUATE, run_apart


@pytest.mark.parametrize(
    ("without", "environment", "why"),
    [
        ("import sys; sys.modules['numba'] = None", {}, "is not installed"),
        ("", {"NUMBA_DISABLE_JIT": "1"}, "does not compile"),
    ],
)
def test_without_numba_all_works_but_asking_for_it(without, environment, why):
    code = f"""
{without}
{EVALUATE}
assert abs(lit("auto", 300000) - 0.84).max() < 1e-6
try:
    lit("numba")
except ValueError as error:
    print(error)
"""
    assert f"backend must be 'auto' or 'numpy' because Numba {why}" in run_apart(code, **environment)


STAGE = """
from numba.core import types
from pvphong.optics.lights import PointLight
from pvphong.shading.kernel import code as kernel_code, stages
def code():
    stage = stages.light_stage(PointLight().placement.falloff, False)
    return kernel_code.Code(stage, kernel_code.stage_signature(types.float32))
"""


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """Folder with the code of one stage."""
    folder = tmp_path_factory.mktemp("kept")
    assert run_apart(STAGE + "print(code().cache_hits)", NUMBA_CACHE_DIR=str(folder)) == "0\n"
    return folder


@pytest.fixture
def folder(kept, tmp_path):
    """Copy of `kept` for one test."""
    return shutil.copytree(kept, tmp_path / "kept")


DAMAGE = """
import hashlib, sys
from pathlib import Path
(file,) = Path(sys.argv[1]).rglob("*.pvphong")
whole = file.read_bytes()
middle = len(whole) // 2
for name, damaged in {
    "empty": b"",
    "cut short": whole[:-1],
    "cut to digests": whole[:40],
    "a bit of machine code turned": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
    "of other sources": bytes([whole[0] ^ 1]) + whole[1:],
    "no pickle": whole[:32] + hashlib.sha256(b"no pickle").digest() + b"no pickle",
}.items():
    file.write_bytes(damaged)
    print(name, code().cache_hits, code().cache_hits)
"""


def test_a_damaged_file_is_replaced(folder):
    (file,) = folder.rglob("*.pvphong")
    told = run_apart(STAGE + DAMAGE, str(folder), NUMBA_CACHE_DIR=str(folder))
    assert len(told.splitlines()) == 6
    assert all(line.endswith(" 0 1") for line in told.splitlines()), told
    assert [path.name for path in folder.rglob("*.pvphong")] == [file.name]


CHANGES = """
import os
from pathlib import Path
from unittest import mock
from numba.core.codegen import JITCPUCodegen
(file,) = Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.pvphong")
whole = file.read_bytes()
for changed in (
    mock.patch.object(kernel_code, "_sources", lambda _: b"others"),
    mock.patch.object(kernel_code, "_VERSIONS", ("0.1", "of NumPy")),
    mock.patch.object(JITCPUCodegen, "magic_tuple", lambda _: ("another processor",)),
):
    file.write_bytes(whole)
    print(code().cache_hits)
    with changed:
        print(code().cache_hits)
"""


def test_what_code_was_made_of_counts(folder):
    """A change of sources, versions or processor invalidates code."""
    assert run_apart(STAGE + CHANGES, NUMBA_CACHE_DIR=str(folder)).split() == ["1", "0"] * 3


OWN = """
from pvphong.base.formulas import ONE, formula
from pvphong.shading.kernel import code as kernel_code, stages
{imports}
@formula
def falloff(own, l):
    return {value}, l[0]
store = kernel_code.store_of(stages.light_stage(falloff, False))
"""


def test_a_helper_of_a_users_formula_counts_wherever_it_is(tmp_path):
    (tmp_path / "mine.py").write_text(OWN.format(imports="from helper import half", value="half(l)"))
    found = set()
    for value in ("0.5", "0.25"):
        helper = f"from pvphong.base.formulas import formula\n@formula\ndef half(l):\n    return {value}\n"
        (tmp_path / "helper.py").write_text(helper)
        found.add(run_apart("import mine; print(mine.store._sources.hex())", PYTHONPATH=path_with(tmp_path)))
    assert len(found) == 2


def test_of_a_formula_that_was_typed_into_an_interpreter_no_code_is_kept():
    assert run_apart(OWN.format(imports="", value="ONE") + "print(store)") == "None\n"


def path_with(folder):
    return os.pathsep.join([str(folder), *filter(None, sys.path)])


def test_where_nothing_can_be_written_it_is_compiled_each_time(folder):
    shutil.rmtree(folder)
    code = f"""
from unittest import mock
from pathlib import Path
{STAGE}
with mock.patch.object(Path, "write_bytes", side_effect=OSError("no space left on the device")):
    assert code().address
"""
    run_apart(code, NUMBA_CACHE_DIR=str(folder))
    assert [path for path in folder.rglob("*") if not path.is_dir()] == []


@pytest.mark.parametrize("beyond", ["", "sub"])
def test_a_file_in_the_place_of_the_folder_is_passed_over(tmp_path, beyond):
    file = tmp_path / "file"
    file.write_text("mine")
    code = f"""
{EVALUATE}
from pvphong.shading import kernel
folder = kernel._library().folder
assert folder is None or folder.is_dir()
assert abs(lit("auto", 300000) - 0.84).max() < 1e-6
"""
    run_apart(code, NUMBA_CACHE_DIR=str(file / beyond))
    assert file.read_text() == "mine"


def test_a_folder_in_the_place_of_a_file_is_passed_over(folder):
    (file,) = folder.rglob("*.pvphong")
    file.unlink()
    file.mkdir()
    assert run_apart(STAGE + "print(code().cache_hits, code().cache_hits)", NUMBA_CACHE_DIR=str(folder)) == "0 0\n"
    assert [path.name for path in folder.rglob("*.pvphong")] == [file.name]


# --- threads, processors and processes ---


def test_numbas_setting_is_the_most():
    code = "from pvphong.base import threads; print(threads.count())"
    assert run_apart(code, NUMBA_NUM_THREADS="1") == "1\n"


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_forked_child_has_its_own():
    code = f"""
{EVALUATE}
import os
assert abs(lit("numba", 300000) - 0.84).max() < 1e-6
child = os.fork()
if not child:
    os._exit(0 if abs(lit("numba", 300000) - 0.84).max() < 1e-6 else 1)
assert os.waitpid(child, 0)[1] == 0
print(lit("numba", 300000))
"""
    assert "0.84" in run_apart(code)


def test_several_python_threads_may_evaluate_at_once():
    code = f"""
{EVALUATE}
from concurrent.futures import ThreadPoolExecutor
with ThreadPoolExecutor(4) as callers:
    for colour in callers.map(lambda _: lit("numba", 200000), range(12)):
        assert abs(colour - 0.84).max() < 1e-6
"""
    run_apart(code)
