"""Every public name has an example in its docstring, and all examples run and print the documented output."""

import doctest
import inspect
import re
import warnings

import pytest
import pyvista as pv

import pvphong as ph
from pvphong.accessor import BlocksPhong, MeshPhong
from pvphong.plotter import PlotterPhong

ACCESSORS = (MeshPhong, BlocksPhong, PlotterPhong)
PUBLIC = dict(
    [
        *((name, getattr(ph, name)) for name in ph.__all__ if name != "pipeline"),
        *((f"pipeline.{name}", getattr(ph.pipeline, name)) for name in ph.pipeline.__all__),
        *((kind.__name__, kind) for kind in ACCESSORS),
    ]
)
METHODS = {
    f"{kind}.{name}": getattr(member, "__func__", member)
    for kind, found in PUBLIC.items()
    if inspect.isclass(found)
    for name, member in vars(found).items()
    if not name.startswith("_") and ">>>" in (getattr(member, "__doc__", None) or "")
}
WAITS = ("PlotterPhong.studio",)
"""Names whose example is not run, because it would wait for a browser."""


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_an_example(name):
    assert ">>> " in (PUBLIC[name].__doc__ or "")


@pytest.mark.parametrize("kind", ACCESSORS, ids=lambda kind: kind.__name__)
def test_every_method_of_an_accessor_is_in_an_example(kind):
    for name in dir(kind):
        if not name.startswith("_"):
            own = getattr(kind, name).__doc__ or ""
            used = re.search(rf"^\s*>>> .*\.{name}\b", kind.__doc__ + own, flags=re.MULTILINE)
            assert used or ">>> " in own, name


def test_no_example_is_skipped_but_those_that_wait():
    assert {name for name, found in (PUBLIC | METHODS).items() if "+SKIP" in found.__doc__} == set(WAITS)


@pytest.mark.parametrize("name", PUBLIC | METHODS)
def test_the_example_prints_what_it_says(name, monkeypatch, tmp_path):
    monkeypatch.setattr(pv, "OFF_SCREEN", True)
    monkeypatch.chdir(tmp_path)
    doc = inspect.cleandoc((PUBLIC | METHODS)[name].__doc__)
    test = doctest.DocTestParser().get_doctest(doc, {}, name, None, 0)
    printed = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    with warnings.catch_warnings():  # examples about warnings change the filters
        runner.run(test, out=printed.append)
    pv.close_all()
    assert not runner.failures, "".join(printed)
