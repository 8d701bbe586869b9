"""The commands put together, and what their errors come to."""

from __future__ import annotations

import sys
import traceback
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
    help_epilogue="With --verbose any command shows what libraries print on the error output.",
    version=version("pvphong"),
    suppress_keyboard_interrupt=False,
)
for command in (demo, shade, view, plan, validate, tradeoff, diagnose):
    app.command(command)
app.command(compile_code, name="compile")


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the command line in this process and give the exit status."""
    return work(sys.argv[1:] if tokens is None else tokens, verbose=False)


def work(tokens: Sequence[str], verbose: bool) -> int:
    """What `main` does; with `verbose`, errors that nobody has foreseen are shown with where they came from."""
    try:
        status = app(tokens, exit_on_error=False, print_error=False, result_action="return_value") or 0
        if sys.stdout is not None:
            sys.stdout.flush()
    except (CycloptsError, ValueError, OSError) as error:
        return _refused(str(error))
    except KeyboardInterrupt:
        return 130
    except MemoryError:
        return _refused("there is not enough memory for this.")
    except Exception as error:
        if verbose:
            traceback.print_exc()
        return _refused(f"{type(error).__name__}: {error} (this should not happen; --verbose shows where)")
    return status


def _refused(why: str) -> int:
    print("error:", " ".join(why.split()), file=sys.stderr)
    return 2
