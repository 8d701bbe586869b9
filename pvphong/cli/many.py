"""`pvphong shade` for many files: where they are lit, and how what came of them is told."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from pvphong.base import check
from pvphong.batch.pieces import Seams, is_pattern
from pvphong.batch.shading import shade_files
from pvphong.cli.options import Blockers, refuse_given
from pvphong.cli.spinner import busy
from pvphong.scene.scene import Scene


@dataclass(frozen=True)
class ManyFiles:
    """Many files: who lights them.

    Parameters
    ----------
    workers
        How many processes light them here; as many as there are processors if not given.
    scheduler
        The address of a Dask scheduler, as tcp://host:8786, of which the workers light them.
    seams
        "merge" gives points at one place the normal of all pieces' faces there, "keep" that of their own piece's; if
        not given, pieces that a .vtm, .pvtp, .pvtu or .pvd file names are merged.
    """

    workers: int | None = None
    scheduler: str | None = None
    seams: Seams | None = None

    def refuse_any(self) -> None:
        """Raise ``ValueError`` if one is given."""
        refuse_given(
            {f"--{name}": given for name, given in vars(self).items()},
            "left out where a single mesh is lit into a file; -o FOLDER/ is for many",
        )

    def shade(
        self, meshes: Sequence[str], output: str, scene: Path | None, blockers: Blockers, how: Mapping[str, Any]
    ) -> int:
        """Light all of them, tell what came of it, and give the exit status."""
        if self.workers is not None and self.scheduler is not None:
            check.refuse("--workers", self.workers, "left out beside --scheduler, which has its own")
        refuse_given({"--occluder": blockers.occluder}, "left out where many files are lit, each by itself")
        if scene is None:
            blocked = {"--shadows": blockers.shadows, "--ambient-occlusion": blockers.ambient_occlusion}
            refuse_given(blocked, "left out without --scene where many files are lit")
        with busy("Lighting many files"):
            batch = shade_files(
                meshes,
                output,
                None if scene is None else blockers.to_scene(Scene.load(scene)),
                client=self.scheduler,
                workers=self.workers,
                seams=self.seams,
                **how,
            )
        print(batch, file=sys.stderr if batch.failed else sys.stdout)
        return 1 if batch.failed else 0


ManyFilesOptions = Annotated[ManyFiles, Parameter(name="*")]
HERE = ManyFiles()
"""None of its options given."""


def are_many(meshes: Sequence[str], output: str) -> bool:
    """Whether a folder is to be filled, and not a file written."""
    is_folder = output.endswith(("/", os.sep)) or os.path.isdir(output)
    return is_folder or len(meshes) > 1 or is_pattern(meshes[0])
