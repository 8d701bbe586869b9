"""What keys do to the view of the lights: help, gizmos, selection, undo."""

from __future__ import annotations

from pvphong.studio.gizmos.surroundings import Surroundings


def toggle_help(board: Surroundings) -> None:
    """Show all keys, or hide them."""
    board.helping = not board.helping


def toggle_hidden(board: Surroundings) -> None:
    """Hide all gizmos, or show them."""
    board.hidden = not board.hidden
    board.notice = "gizmos hidden: g shows them" if board.hidden else ""


def select_next(board: Surroundings) -> None:
    """Select the next light, also one without handles: keys act on it; after the last none."""
    ring = [None, *board.gizmos]
    at = ring.index(board.selected) if board.selected in ring else 0
    chosen = ring[(at + 1) % len(ring)]
    board.select(chosen)
    board.notice = "" if chosen else "no light selected"


def undo(board: Surroundings) -> None:
    """Take the last step back."""
    board.notice = "undone" if board.history.undo() else "nothing to undo"


def redo(board: Surroundings) -> None:
    """Take the last step that was undone again."""
    board.notice = "done again" if board.history.redo() else "nothing to redo"
