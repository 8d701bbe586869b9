"""Where the values of a block of faces stand in scratch memory, for normals: row after row in one flat array."""

from __future__ import annotations

# Corners in a block, and so the most that a face may have.
CORNERS = 384

# Faces in a block at most.
FACES = CORNERS // 3

# Rows of corners: points, edges from each to the next, weights.
PX, PY, PZ, EX, EY, EZ, WEIGHT, _END = range(0, 8 * CORNERS, CORNERS)

# Rows of faces: vectors as long as twice the area, then unit normals; the magnitudes of what those are summed of; the
# lengths; 1, or 0 for a face without a normal; and the length of all rows.
NX, NY, NZ, TX, TY, TZ, AREA, HAS_NORMAL, ROWS = range(_END, _END + 9 * FACES, FACES)

# Faces in a chunk, of which the least and the greatest index are known.
CHUNK = 4096

# Numbers in the sums of a point: x, y, z, and the weights' magnitudes.
SUMS = 4

# The weightings; compiled code gets the place of one.
WEIGHTINGS = "angle", "area", "max"
