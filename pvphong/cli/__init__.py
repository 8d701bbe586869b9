"""The command line: `pvphong`, or `python -m pvphong`.

Exit status 0 is success; 1 is a mesh that `diagnose` finds fault with, colours that `validate` finds too far from
VTK's, a file of many that `shade` cannot light, or code that `compile` cannot compile or keep; 2 is bad input, or a
crash in a library: one line on the error output says which. Ctrl-C gives 130, and a pipe that nobody reads any more
141, as shells have it.

In the order in which to read it: `supervisor` (a parent process, which turns a crash of its child into one line), `app`
(the commands put together, each imported when it is called), `options` (what several commands take, what they read,
and what is shown while they work), then the commands `shade`, `reports` (`plan`, `validate`, `tradeoff`, `diagnose`),
`view`, `studio` and `demo`, all of which call `mesh.phong` or `plotter.phong`, and `compile`.
"""

from pvphong.cli.supervisor import main

__all__ = ["main"]
