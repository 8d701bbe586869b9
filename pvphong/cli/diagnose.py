"""`pvphong diagnose`: what in a mesh will not light as it should."""

from __future__ import annotations

from rich.console import Console

from pvphong.base.limits import reading
from pvphong.cli.inputs import NOTHING, single_meshes
from pvphong.meshes.files import read_mesh
from pvphong.studies.diagnose.diagnosis import diagnose as diagnose_mesh


def diagnose(mesh: str, /) -> int:
    """Say what in a mesh will not light as it should; the exit status is 1 if there is anything.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    """
    with reading(mesh):
        named = {block: diagnose_mesh(single) for block, single in single_meshes(read_mesh(mesh))}
    console = Console()
    for block, diagnosis in named.items():
        if block:
            print(f"{block}:")
        if console.is_terminal and diagnosis.findings:
            console.print(diagnosis.table())
        else:  # into a file or another program: unwrapped lines
            print(diagnosis)
    if not named:
        print(NOTHING)
    return 0 if named and all(diagnosis.ok for diagnosis in named.values()) else 1
