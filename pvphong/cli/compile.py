"""`pvphong compile`: the evaluator's code, before it is needed."""

from __future__ import annotations

import sys
import time

from rich.console import Console
from rich.progress import Progress

from pvphong.shading import kernel


def compile_code() -> int:
    """Compile the fast evaluator in advance, once per installation; it says what is in the way if that cannot be done.

    Without this, the first large mesh is lit by NumPy, while another process compiles.
    """
    began = time.perf_counter()
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("compiling", total=None)
        try:
            folder = kernel.compile_all(
                lambda name, done, total: progress.update(task, description=name, completed=done, total=total)
            )
        except kernel.CannotCompile as reason:
            print("error:", reason, file=sys.stderr)
            return 1
    print(f"compiled in {time.perf_counter() - began:.0f} s, kept in {folder}")
    return 0
