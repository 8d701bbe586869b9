"""`pvphong compile`: compile the fast evaluator in advance."""

from __future__ import annotations

import sys
import time

from rich.console import Console
from rich.progress import Progress

from pvphong.rays.casting import ray_backend
from pvphong.shading import kernel


def compile_code() -> int:
    """Compile the fast evaluator in advance, once per installation.

    If it has not been compiled, NumPy lights the first large meshes while another process compiles. The command also
    prints the ray tracer in use and, if it is not the fastest, the reason.
    """
    began, console = time.perf_counter(), Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task("compiling", total=None)
        try:
            folder = kernel.compile_all(
                lambda name, done, total: progress.update(task, description=name, completed=done, total=total)
            )
        except kernel.CannotCompile as reason:
            print("error:", reason, file=sys.stderr)
            return 1
        finally:
            progress.stop()
            backend, why_no_faster = ray_backend()
            print(f"ray tracer: {backend.title}" + (f": {why_no_faster}" if why_no_faster else ""))
    print(f"compiled in {time.perf_counter() - began:.0f} s, saved in {folder}")
    return 0
