"""Sphinx's configuration of the manual: ``python -m sphinx -W examples/guide site``.

The build runs every script in `examples`, so it needs pvphong's extras, and neither a display nor a network. What it
writes next to the sources, `gallery` and `reference/generated`, is ignored by git.
"""

import os
import sys
import tomllib
from pathlib import Path

os.environ["PYVISTA_OFF_SCREEN"] = "true"  # also for processes that examples start

import matplotlib as mpl
import pyvista as pv
from sphinx.application import Sphinx
from sphinx.util import logging

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
]
exclude_patterns = ["**/sg_execution_times.rst"]
templates_path = ["reference/templates"]
default_role = "py:obj"  # a name in back-quotes links to its page, if it has one
nitpicky = False
suppress_warnings = ["config.cache"]  # sphinx-gallery's configuration has classes

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_typehints = "none"  # docstrings give types
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the template of classes lists them
numpydoc_class_members_toctree = False

html_theme = "pydata_sphinx_theme"
html_title = "pvphong"
html_show_sourcelink = False
html_theme_options = {"show_toc_level": 2, "navigation_with_keys": False, "secondary_sidebar_items": ["page-toc"]}
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


def setup(app: Sphinx) -> None:
    """Look at the pictures once the examples have run."""
    app.connect("builder-inited", look_at_pictures, priority=900)
