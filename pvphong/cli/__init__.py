"""The command line: `pvphong`, or `python -m pvphong`.

Exit status:

- 0: success.
- 1: `diagnose` found a fault, `validate` found colours too far from VTK's, `shade` could not light one of many files,
  or `compile` failed.
- 2: bad input, or a crash in a library, with one line on standard error.
- 130 after Ctrl-C, 141 for a closed pipe, as in shells.

In reading order:

- `supervisor`: parent process, which reports a crash of its child in one line.
- `app`: table of commands, which are imported on demand.
- `options`: common options, reading of inputs, and progress.
- `irradiance`: command that computes the light that arrives, in the unit of the lights.
- `shade`, `reports` (`plan`, `validate`, `tradeoff`, `diagnose`), `view`, `studio`, `demo`: commands, which call
  `mesh.phong` or `plotter.phong`.
- `daylight`: command for sun and sky over time.
- `compile`: command that compiles the fast evaluator.
"""

from pvphong.cli.supervisor import main

__all__ = ["main"]
