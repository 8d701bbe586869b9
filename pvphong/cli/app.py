"""The commands put together, and what their errors come to."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError

from pvphong.cli.compile import compile_code
from pvphong.cli.demo import demo
from pvphong.cli.diagnose import diagnose
from pvphong.cli.plan import plan
from pvphong.cli.shade import shade
from pvphong.cli.tradeoff import tradeoff
from pvphong.cli.validate import validate
from pvphong.cli.view import view

app = App(
    name="pvphong",
    help="Phong lighting of meshes as data: lit colours as arrays, in files and in pictures.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)
for command in (demo, shade, view, plan, validate, tradeoff, diagnose):
    app.command(command)
app.command(compile_code, name="compile")


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line and give the exit status."""
    try:
        return app(tokens, exit_on_error=False, print_error=False, result_action="return_value") or 0
    except (CycloptsError, ValueError, OSError) as error:
        print("error:", " ".join(str(error).split()), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
