"""What came of many files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pvphong.base.text import html_table, wrapped


@dataclass(frozen=True)
class Batch:
    """What came of many files; each is in one of the three.

    Attributes
    ----------
    done : tuple of Path
        The files that were lit now, and the indices that were written.
    skipped : tuple of Path
        Those of which the lit file was there already, made from the same file, rig and version.
    failed : mapping of Path to str
        Those that could not be lit, and why. Nothing was written for them.
    note : str
        What was left as it is, if there is anything to say: seams between files.
    """

    done: tuple[Path, ...]
    skipped: tuple[Path, ...]
    failed: Mapping[Path, str]
    note: str = ""

    def __str__(self) -> str:
        counts = f"{len(self.done)} done, {len(self.skipped)} skipped, {len(self.failed)} failed."
        reasons = [line for path, why in self.failed.items() for line in wrapped(f"{path}: {why}")]
        return "\n".join([counts, *reasons, *wrapped(self.note)])

    def __repr__(self) -> str:
        return f"<Batch: {len(self.done)} done, {len(self.skipped)} skipped, {len(self.failed)} failed>"

    def _repr_html_(self) -> str:
        rows = [(str(path), why) for path, why in self.failed.items()]
        return html_table(repr(self)[1:-1], ("failed", "why") if rows else (), rows)
