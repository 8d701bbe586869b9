"""The command line: `pvphong`, or `python -m pvphong`.

Exit status 0 is success. 1: `diagnose` found a fault, `validate` found colours too far from VTK's, `shade` could not
light one of many files, or `compile` failed. 2: bad input, or a crash in a library, with one line on the error output.
Ctrl-C gives 130 and a closed pipe 141, as in shells.

In reading order: `supervisor` (a parent process that turns a crash of its child into one line), `app` (the table of
commands, each imported on demand), `options` (common options, reading of inputs, and progress), then the
commands `shade`, `reports` (`plan`, `validate`, `tradeoff`, `diagnose`),
`view`, `studio` and `demo`, all of which call `mesh.phong` or `plotter.phong`, and `compile`.
"""

from pvphong.cli.supervisor import main

__all__ = ["main"]
