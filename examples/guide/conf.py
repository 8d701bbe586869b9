"""Sphinx's configuration of the manual: ``python -m sphinx -W examples/guide site``.

The build runs every script in `examples`, so it needs pvphong's extras, and neither a display nor a network. What it
writes next to the sources, `gallery` and `reference/generated`, is ignored by git.
"""

import os
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

os.environ["PYVISTA_OFF_SCREEN"] = "true"  # also for processes that examples start

import matplotlib as mpl
import pyvista as pv
from docutils import nodes, utils
from numpydoc.xref import DEFAULT_LINKS
from sphinx.application import Sphinx
from sphinx.domains.python import PyXRefRole
from sphinx.ext.autosummary import import_by_name
from sphinx.util import logging

import pvphong as ph

GUIDE = Path(__file__).parent
sys.path.insert(0, str(GUIDE))
from gallery_support import ORDER, faults_of, has_two_halves  # noqa: E402 it lies next to this file

mpl.use("agg")
pv.BUILDING_GALLERY = True
pv.OFF_SCREEN = True

project = "pvphong"
author = "the pvphong developers"
version = release = tomllib.loads(GUIDE.parents[1].joinpath("pyproject.toml").read_text("utf-8"))["project"]["version"]
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_gallery.gen_gallery",
    *(path.stem for path in GUIDE.glob("field_tables.py")),  # where the guide has tables of fields
]
exclude_patterns = ["**/sg_execution_times.rst"]
templates_path = ["templates"]
default_role = "name"  # see `Name` below
nitpicky = False
suppress_warnings = ["config.cache"]  # sphinx-gallery's configuration has classes

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "none"  # docstrings give types
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the template of classes lists them
numpydoc_class_members_toctree = False
numpydoc_xref_param_type = True
numpydoc_xref_aliases = {word: word for word in DEFAULT_LINKS} | {name: f"pvphong.{name}" for name in ph.__all__}
numpydoc_xref_ignore = "all"  # only the names of this package have pages here

html_theme = "pydata_sphinx_theme"
html_title = "pvphong"
html_show_sourcelink = False
html_theme_options = {
    "show_toc_level": 2,
    "navbar_center": [],  # the sidebar has all pages
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {"**": ["manual-nav"]}
html_static_path = ["static"]
html_css_files = ["manual.css"]

sphinx_gallery_conf = {
    "examples_dirs": "..",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "gallery_support.in_order",
    "image_scrapers": ("gallery_support", "matplotlib"),  # the first is PyVista's
    "reset_modules": ("matplotlib", "gallery_support.reset"),
    "doc_module": ("pvphong",),
    "backreferences_dir": "reference/generated",
    "capture_repr": (),
    "show_memory": False,
    "write_computation_times": False,
    "download_all_examples": False,
    "remove_config_comments": True,
    "nested_sections": False,
    "thumbnail_size": (480, 336),
}


def look_at_pictures(app: Sphinx) -> None:
    """Warn of each example without a picture, and of each picture that shows nothing."""
    logger = logging.getLogger("pvphong.gallery")
    images = Path(app.srcdir, "gallery", "images")
    for example in ORDER:
        pictures = [path for ext in ("png", "gif") for path in sorted(images.glob(f"sphx_glr_{example}_[0-9]*.{ext}"))]
        if not pictures:
            logger.warning("examples/%s.py leaves no picture", example)
        for picture in pictures:
            for fault in faults_of(picture):
                logger.warning("examples/%s.py leaves a bad picture, %s: %s", example, picture.name, fault)
            if example == "hard_cases" and not has_two_halves(picture):
                logger.warning("examples/%s.py shows the same colours twice: %s", example, picture.name)


class Name(PyXRefRole):
    """Text in single back-quotes: a link if it is the name of a page here, and code otherwise."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return a link that may stay unresolved, or code."""
        if not re.fullmatch(r"[A-Za-z_][\w.]*(\(\))?", utils.unescape(self.text)):
            return [nodes.literal(self.rawtext, utils.unescape(self.text))], []
        self.name = "py:obj"
        return super().run()


def link_by_public_name(app: Sphinx, env: Any, node: nodes.Element, text: nodes.Element) -> nodes.Node | None:
    """Link a name by its module, as in pvphong.shading.plan.plan.Plan, to its page; warn of a name that is none."""
    target = node.get("reftarget", "")
    if not target.startswith("pvphong."):
        return None
    try:
        found = import_by_name(target)[1]
    except ImportError:
        logging.getLogger("pvphong.links").warning("there is no %s", target, location=node)
        return None
    for module in (ph, ph.pipeline):
        for name in module.__all__:
            if getattr(module, name) is found and f"{module.__name__}.{name}" != target:
                node["reftarget"] = f"{module.__name__}.{name}"
                return env.domains["py"].resolve_xref(
                    env, node["refdoc"], app.builder, "obj", node["reftarget"], node, text
                )
    return None


def escape_bars(_app: Sphinx, _what: str, _name: str, _of: object, _options: object, lines: list[str]) -> None:
    """Keep the bars of a formula, as in |l + v|, from being a substitution."""
    for number, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...", "+", "|")):
            parts = re.split(r"(`+[^`]*`+)", line)
            lines[number] = "".join(part if part[:1] == "`" else part.replace("|", "\\|") for part in parts)


def setup(app: Sphinx) -> None:
    """Look at the pictures once the examples have run, and at links once pages are read."""
    app.connect("builder-inited", look_at_pictures, priority=900)
    app.connect("autodoc-process-docstring", escape_bars)
    app.connect("missing-reference", link_by_public_name)
    app.add_role("name", Name())
