"""Compiled code is kept on disk where that is possible, and does without where it is not."""

from __future__ import annotations

import shutil

import pytest
from shading.kernel.apart import EVALUATE, run_apart

from pvphong.shading import kernel

pytest.importorskip("numba", reason="the extra `fast` is not installed")
pytestmark = pytest.mark.skipif(not kernel.is_available(), reason="Numba cannot run here")


def test_without_numba_all_works_but_asking_for_it():
    code = f"""
import sys
sys.modules["numba"] = None
{EVALUATE}
assert abs(lit("auto", 300000) - 0.84).max() < 1e-6
try:
    lit("numba")
except ValueError as error:
    print(error)
"""
    assert "backend must be 'auto' or 'numpy' where Numba is not installed" in run_apart(code)


def test_numba_told_not_to_compile_is_as_if_it_were_not_there():
    code = f"""
{EVALUATE}
print(lit("auto", 300000))
try:
    lit("numba")
except ValueError as error:
    print(error)
"""
    said = run_apart(code, NUMBA_DISABLE_JIT="1")
    assert "0.84" in said
    assert "where Numba does not compile" in said


def test_importing_pvphong_does_not_import_numba():
    run_apart("import sys, pvphong; assert 'numba' not in sys.modules")


def test_without_a_folder_for_compiled_code_it_is_no_failure_but_not_worth_compiling():
    code = f"""
from unittest import mock
from numba.core import caching
from pvphong.shading import kernel
{EVALUATE}
# The tests may run as root, for whom no folder is closed.
with mock.patch.object(caching._CacheLocator, "ensure_cache_path", side_effect=PermissionError):
    assert kernel.is_available()
    assert not kernel.keeps_code()
    with mock.patch.object(kernel, "shade", side_effect=AssertionError("it compiles")):
        print(lit("auto", 300000))
"""
    assert run_apart(code).count("0.84") == 3


STAGE = """
from numba.core import types
from pvphong.optics.lights import PointLight
from pvphong.shading.kernel import keeping, toolkit
def code():
    signature = keeping._stage_of_light(types.float32)
    return keeping.compiled(PointLight().stage(toolkit).function, signature)
"""


@pytest.fixture
def folder(tmp_path):
    """Where one stage's code is kept."""
    assert run_apart(STAGE + "print(code().cache_hits)", NUMBA_CACHE_DIR=str(tmp_path)) == "0\n"
    assert run_apart(STAGE + "print(code().cache_hits)", NUMBA_CACHE_DIR=str(tmp_path)) == "1\n"
    return tmp_path


@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_a_damaged_file_is_replaced(folder, kind):
    (damaged,) = folder.rglob(f"*.{kind}")
    damaged.write_text("damaged")
    assert run_apart(STAGE + "print(code().cache_hits)", NUMBA_CACHE_DIR=str(folder)) == "0\n"
    assert run_apart(STAGE + "print(code().cache_hits)", NUMBA_CACHE_DIR=str(folder)) == "1\n"


def test_a_change_of_any_source_that_a_stage_may_call_counts(folder):
    code = STAGE + "keeping._checksum = lambda _: 7\nprint(code().cache_hits)"
    assert run_apart(code, NUMBA_CACHE_DIR=str(folder)) == "0\n"


def test_where_nothing_can_be_written_it_is_compiled_each_time(folder):
    shutil.rmtree(folder)
    code = f"""
from unittest import mock
from numba.core import caching
{STAGE}
with mock.patch.object(caching.IndexDataCacheFile, "save", side_effect=OSError("no space left on the device")):
    assert code().address
"""
    run_apart(code, NUMBA_CACHE_DIR=str(folder))


def test_what_cannot_be_compiled_is_an_error():
    from numba.core import types
    from numba.core.errors import TypingError

    from pvphong.shading.kernel import keeping

    with pytest.raises(TypingError):
        keeping.compiled(lambda rows: rows.nothing, types.boolean(types.CPointer(types.float32)))
