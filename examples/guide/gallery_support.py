"""The order of the gallery's examples, what keeps them apart, and a look at each picture that they leave."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pyvista as pv
from PIL import Image, ImageSequence
from pyvista.plotting.utilities.sphinx_gallery import Scraper as PyVistaScraper

ORDER = (
    *("lit_airplane", "lights_as_data"),
    *("lights_with_a_size", "metal_and_plastic", "reflectances", "opengl_defaults"),
    *("shadows_as_data", "crisp_shadows", "coarse_shadows", "light_that_bounces", "phong_and_the_truth"),
    *("room_in_lux", "city_in_the_sun", "terrain_year"),
    *("place_lights", "live_window", "moving_light", "studio", "in_a_browser"),
    *("normals_under_shear", "hard_cases", "only_what_it_needs", "accuracy_costs_time", "many_files"),
)
"""Examples as the gallery shows them: from what to read first to what to look up."""


def in_order(filename: str) -> int:
    """Return the place of an example in the gallery.

    Raises
    ------
    ValueError
        If the example has no place in `ORDER`.
    """
    return ORDER.index(Path(filename).stem)


class Scraper:
    """PyVista's scraper, without the plotters that pvphong closes itself when it measures VTK's shader."""

    def __repr__(self) -> str:
        return "<the gallery's scraper>"

    def __call__(self, block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
        """Save the pictures of a block and return their reStructuredText."""
        plotters = pv.plotting.plotter._ALL_PLOTTERS
        for name, plotter in list(plotters.items()):
            if plotter._closed and plotter.last_image is None and plotter._gif_filename is None:
                del plotters[name]
        return PyVistaScraper()(block, variables, gallery)


def _get_sg_image_scraper() -> Scraper:
    """Return the scraper; sphinx-gallery calls this for a module among ``image_scrapers``."""
    return Scraper()


def reset(_gallery: dict[str, Any], _script: str) -> None:
    """Undo what an example leaves behind in the process: plotters, warnings that it silences, a theme."""
    pv.close_all()
    pv.global_theme.restore_defaults()
    warnings.resetwarnings()


def faults_of(picture: Path) -> list[str]:
    """Return what is wrong with a picture that an example left, one phrase for each fault.

    A picture is at fault if it is black, if nearly all of it is background, if it has so few colours that nothing in it
    is shaded, or if it is an animation of one frame.
    """
    with Image.open(picture) as image:
        frames = np.stack([np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)])
    colors, counts = np.unique(frames.reshape(-1, 3) @ np.array((2**16, 2**8, 1)), return_counts=True)
    faults = []
    if frames.max() <= 100:
        faults.append(f"it is black: no channel is above {frames.max()} of 255")
    if counts.max() > 0.95 * counts.sum():
        faults.append(f"{counts.max() / counts.sum():.1%} of it has one colour")
    if len(colors) < 100:
        faults.append(f"it has {len(colors)} colours")
    if picture.suffix == ".gif" and len(frames) < 2:
        faults.append("it does not move")
    return faults


def has_two_halves(picture: Path) -> bool:
    """Whether the left and the right half of a picture differ, in at least a fiftieth of what is drawn."""
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    left, right = pixels[:, : pixels.shape[1] // 2], pixels[:, pixels.shape[1] // 2 :][:, : pixels.shape[1] // 2]
    differ = (np.abs(left - right) > 10).any(axis=2)
    drawn = (right != right[0, 0]).any(axis=2)
    return bool(differ.sum() > 0.02 * drawn.sum() > 0)
