"""Histogram of the displayed luminance. It counts the pixels with a drawn object, not the background and the gizmos."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkFloatArray, vtkUnsignedCharArray

from pvphong.base.color import XYZ_OF_RGB
from pvphong.base.types import ByteArray, Float64Array, IntArray
from pvphong.studio.gizmos import Interaction
from pvphong.studio.lit_actors import LitActors

BINS = 64
"""Default number of bins."""


@dataclass(frozen=True, eq=False, repr=False)
class Histogram:
    """Histogram of the luminance of a picture, from `plotter.phong.histogram()`.

    Attributes
    ----------
    counts : ndarray
        Number of pixels in each bin, shape (bins,).
    edges : ndarray
        Edges of the bins, shape (bins + 1,), from 0 to 1. The luminance of a displayed colour with the channels R, G
        and B from 0 to 1 is 0.2126 R + 0.7152 G + 0.0722 B (ITU-R BT.709).
    clipped_low, clipped_high : float
        Fractions of the pixels, from 0 to 1: black pixels, and pixels with a channel at its maximum.

    Examples
    --------
    >>> import pyvista as pv, pvphong as ph
    >>> plotter = pv.Plotter(off_screen=True, lighting="none")
    >>> lamp = plotter.phong.add_light(ph.DirectionalLight(intensity=3))
    >>> actor = plotter.phong.add_mesh(pv.Plane(i_resolution=4, j_resolution=4), "white rubber")
    >>> plotter.show(cpos="xy", auto_close=False)
    >>> found = plotter.phong.histogram()
    >>> found.counts.shape, found.clipped_high
    ((64,), 1.0)
    >>> plotter.close()
    """

    counts: IntArray
    edges: Float64Array
    clipped_low: float
    clipped_high: float

    def __repr__(self) -> str:
        clipped = f"{self.clipped_low:.1%} black, {self.clipped_high:.1%} clipped"
        return f"<Histogram of {self.counts.sum()} pixels in {len(self.counts)} bins, {clipped}>"


def histogram_of(colors: ByteArray, bins: int = BINS) -> Histogram:
    """Return the histogram, with `bins` bins, of displayed colours, uint8, shape (n, 3)."""
    luminance = colors @ (XYZ_OF_RGB[1] / 255.0).astype(np.float32)
    counts, edges = np.histogram(luminance.clip(0.0, 1.0), bins, (0.0, 1.0))
    count = max(len(colors), 1)
    black, bright = ~colors.any(axis=1), colors.max(axis=1, initial=0) == 255
    return Histogram(counts, edges, int(black.sum()) / count, int(bright.sum()) / count)


def drawn_colors(renderer: Any) -> ByteArray:
    """Return the colours of the pixels on which the renderer's last frame has drawn an object, uint8, shape (n, 3)."""
    window, (x, y), (width, height) = renderer.GetRenderWindow(), renderer.GetOrigin(), renderer.GetSize()
    if width < 1 or height < 1:
        return np.zeros((0, 3), np.uint8)
    box, pixels = (x, y, x + width - 1, y + height - 1), vtkUnsignedCharArray()
    window.GetRGBACharPixelData(*box, 0, pixels, 0)
    colors: ByteArray = vtk_to_numpy(pixels).reshape(-1, 4)
    is_drawn = colors[:, 3] > 0
    if is_drawn.all():  # also where the background is a gradient or an image
        depths = vtkFloatArray()
        window.GetZbufferData(*box, depths)
        is_drawn = vtk_to_numpy(depths) < 1.0
    return colors[is_drawn, :3]


def displayed(renderer: Any, lit: LitActors, interaction: Interaction | None) -> ByteArray:
    """Draw a frame without gizmos and overlay, and return the colours of the pixels that show an object, shape (n, 3).

    Parameters
    ----------
    renderer
        VTK's renderer.
    lit : LitActors
        The renderer's lit meshes.
    interaction : Interaction, optional
        The renderer's gizmos.
    """
    display = lit.display
    with nullcontext() if interaction is None else interaction.out_of_sight():
        lit.display = replace(display, overlay="none")
        try:
            renderer.GetRenderWindow().Render()
            return drawn_colors(renderer)
        finally:
            lit.display = display
