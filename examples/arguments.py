"""Arguments of every example: where to leave its picture, and whether to open a window."""

from argparse import ArgumentParser
from pathlib import Path

parser = ArgumentParser()
parser.add_argument("folder", nargs="?", default=".", type=Path, help="where the picture goes; here if not given")
parser.add_argument("--window", action="store_true", help="open a window, and write the picture when it is closed")
given = parser.parse_args()

FOLDER: Path = given.folder
WINDOW: bool = given.window
OFF_SCREEN = None if WINDOW else True
"""For `pyvista.Plotter`; with None it does as PyVista is set up."""
