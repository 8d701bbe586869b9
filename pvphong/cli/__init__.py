"""The command line: `pvphong`, or `python -m pvphong`.

Exit status 0 is success. 1 means that `diagnose` finds a fault, `validate` finds colours too far from VTK's, `shade`
cannot light one of many files, or `compile` cannot compile or save the code. 2 means bad input or a crash in a library;
one line on the error output explains it. As in shells, Ctrl-C gives 130 and a closed output pipe 141.

Reading order: `supervisor` (a parent process, which turns a crash of its child into one line), `app` (the commands,
each imported when it is called), `options` (common options, reading of files, progress), then the commands `shade`,
`reports` (`plan`, `validate`, `tradeoff`, `diagnose`), `view`, `studio` and `demo`, all of which call `mesh.phong` or
`plotter.phong`, and `compile`.
"""

from pvphong.cli.supervisor import main

__all__ = ["main"]
