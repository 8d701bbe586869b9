"""Files that are there whole or not at all."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pvphong.base import check


@contextmanager
def written_aside(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A temporary path beside `path` to write to; renamed to it at the end, removed if anything fails.

    The temporary name keeps the suffix, because writers choose their format by it.

    Raises
    ------
    ValueError
        If the folder does not exist or cannot be written to, or if writing fails.
    """
    target = Path(path).resolve()  # a link keeps pointing to the file
    folder = target.parent
    if not folder.is_dir():
        check.refuse("path", target, "in a folder that exists", f"Create {folder} first.")
    if target.is_dir():
        check.refuse("path", target, "a file", "It is a folder.")
    try:
        aside = Path(tempfile.mkdtemp(prefix=".pvphong-", dir=folder))
    except OSError as error:
        raise ValueError(f"path must be in a folder that can be written to; got {target} ({error}).") from error
    try:
        yield aside / target.name
        (aside / target.name).replace(target)
    except OSError as error:
        raise ValueError(f"path must be a file that can be written; got {target} ({error}).") from error
    finally:
        for left_over in aside.iterdir():
            left_over.unlink()
        aside.rmdir()


def write_json(document: Any, path: str | os.PathLike[str]) -> None:
    """Write plain values to a JSON file.

    Raises
    ------
    ValueError
        If the file cannot be written.
    """
    with written_aside(path) as aside:
        aside.write_text(json.dumps(document, indent=2) + "\n", encoding="utf-8")
