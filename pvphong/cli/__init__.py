"""The command line: `pvphong`, or `python -m pvphong`.

Exit status 0 is success; 1 is a mesh that `diagnose` finds fault with, colours that `validate` finds too far from
VTK's, or code that `compile` cannot compile or keep; 2 is bad input: one line on the error output says which.
"""

from pvphong.cli.app import main

__all__ = ["main"]
