"""`pvphong diagnose`: what in a mesh will not light as it should."""

from __future__ import annotations

from pvphong.base.processes import reading
from pvphong.cli.inputs import single_meshes
from pvphong.cli.options import Verbose
from pvphong.cli.telling import tell
from pvphong.meshes.files import read_mesh
from pvphong.studies.diagnose.diagnosis import diagnose as diagnose_mesh


def diagnose(mesh: str, /, *, verbose: Verbose = False) -> int:
    """Say what in a mesh will not light as it should; the exit status is 1 if there is anything.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads.
    """
    with reading(mesh):
        named = {block: diagnose_mesh(single) for block, single in single_meshes(read_mesh(mesh))}
    tell(named.items(), verbose)
    return 0 if named and all(diagnosis.ok for diagnosis in named.values()) else 1
