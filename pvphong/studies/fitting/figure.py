"""Target, result and difference of a fit side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv

from pvphong.meshes.blocks import datasets
from pvphong.meshes.pictures import aim
from pvphong.studies.fitting.target import LUMINANCE

_DIFFERENCE = "difference in luminance"

# Colour of points for which nothing is asked, on dark and light surfaces alike.
_ANY = (0.62, 0.60, 0.72)


def show(fit: Any, off_screen: bool | None, screenshot: Any, window_size: tuple[int, int], background: str) -> Any:
    """Draw the three panes of a `Fit`; arguments as for `Fit.plot`."""
    parts = dict(datasets(fit.lit)) if isinstance(fit.lit, pv.MultiBlock) else {"": fit.lit}
    panes = {"asked for": fit.asked, "found": None, _DIFFERENCE: fit.differences}
    off = [_brightness(_of(fit.differences, path)) for path in parts]
    most = max(max(float(np.nanmax(np.abs(each), initial=0.0)) for each in off), 1e-3)
    plotter = pv.Plotter(shape=(1, 3), off_screen=off_screen, window_size=list(window_size), border=False)
    ink = "black" if sum(pv.Color(background).float_rgb) > 1.5 else "white"
    for column, (title, values) in enumerate(panes.items()):
        plotter.subplot(0, column)
        plotter.set_background(background)
        for path, part in parts.items():
            drawn = part.copy(deep=False)
            if title == _DIFFERENCE:
                bar = {"title": "", "color": ink, "fmt": "%.2f", "n_labels": 3}
                drawn["difference"] = _brightness(_of(values, path))
                how: Any = {"scalars": "difference", "cmap": "coolwarm", "clim": (-most, most), "nan_color": _ANY}
                plotter.add_mesh(drawn, lighting=False, scalar_bar_args=bar, **how)
                continue
            if values is not None:
                drawn["asked"] = _shown(_of(values, path))
            plotter.add_mesh(drawn, scalars="phong" if values is None else "asked", rgb=True, lighting=False)
        plotter.add_text(title, position=(12, window_size[1] - 36), font_size=12, color=ink)
        aim(plotter, fit.scene.viewer)
        plotter.renderer.ResetCameraClippingRange()
    return plotter.show(screenshot=None if screenshot is None else str(screenshot))


def _of(values: Any, path: str) -> Any:
    return values[path] if isinstance(values, dict) else values


def _brightness(rows: Any) -> Any:
    """Return luminances (n,) for `rows`, which are colours (n, 3) or luminances already."""
    return rows @ LUMINANCE if rows.ndim == 2 else rows


def _shown(rows: Any) -> Any:
    """Return colours (n, 3) to draw, in [0, 1], of `rows`: colours (n, 3) or luminances (n,).

    Luminances become grey. Rows that are NaN, where no colour is asked for, become the colour `_ANY`.
    """
    colors = np.clip(rows if rows.ndim == 2 else np.tile(rows[:, None], 3), 0.0, 1.0)
    return np.where(np.isnan(colors), _ANY, colors)
