"""Every public name has an example in its docstring, and all examples run and print what they say."""

import doctest
import inspect
import warnings

import pytest
import pyvista as pv

import pvphong as ph
from pvphong.accessor import BlocksPhong, MeshPhong
from pvphong.plotter import PlotterPhong

OF_ACCESSORS = [
    *((f"{kind.__name__}.{name}", inspect.getattr_static(kind, name)) for kind in (MeshPhong, PlotterPhong)
      for name in dir(kind) if not name.startswith("_")),
    *((kind.__name__, kind) for kind in (MeshPhong, BlocksPhong, PlotterPhong)),
]  # fmt: skip
PUBLIC = dict(
    [
        *((name, getattr(ph, name)) for name in ph.__all__ if name != "pipeline"),
        *((f"pipeline.{name}", getattr(ph.pipeline, name)) for name in ph.pipeline.__all__),
        *OF_ACCESSORS,
    ]
)
METHODS = {
    f"{kind}.{name}": getattr(member, "__func__", member)
    for kind, found in PUBLIC.items()
    if inspect.isclass(found)
    for name, member in vars(found).items()
    if not name.startswith("_") and ">>>" in (getattr(member, "__doc__", None) or "")
}
SKIPPED = ("PlotterPhong.studio",)
"""Those whose example would wait for a browser."""


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_an_example(name):
    assert ">>> " in (PUBLIC[name].__doc__ or "")
    assert ("+SKIP" in PUBLIC[name].__doc__) == (name in SKIPPED)


@pytest.mark.parametrize("name", PUBLIC | METHODS)
def test_the_example_prints_what_it_says(name, monkeypatch, tmp_path):
    monkeypatch.setattr(pv, "OFF_SCREEN", True)
    monkeypatch.chdir(tmp_path)
    doc = inspect.cleandoc((PUBLIC | METHODS)[name].__doc__)
    test = doctest.DocTestParser().get_doctest(doc, {}, name, None, 0)
    printed = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)
    with warnings.catch_warnings():  # examples of warnings set filters
        runner.run(test, out=printed.append)
    pv.close_all()
    assert not runner.failures, "".join(printed)
