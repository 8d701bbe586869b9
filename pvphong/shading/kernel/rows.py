"""Where a block's values stand in the kernel's scratch memory: row after row in one flat array."""

from __future__ import annotations

# Vertices in a block: a multiple of every vector's length, and few enough that the rows in use stay in 32 KiB
# of first-level cache.
BLOCK = 128

# Vertices in a group, the least that a thread is given.
GROUP = 32 * BLOCK

# Bytes in a line of the processor's caches, and in its longest vectors.
LINE = 64

# Colour; and the part of it that the albedo does not multiply, where there is an albedo.
R, G, B, HR, HG, HB = range(0, 6 * BLOCK, BLOCK)

# Factors of one light's lobes, and its strength. Until a stage is done, these are for its own use too.
FIRST, SECOND, THIRD, STRENGTH = range(6 * BLOCK, 10 * BLOCK, BLOCK)

# Normals n, with 1/|n|.
NX, NY, NZ, INVERSE = range(10 * BLOCK, 14 * BLOCK, BLOCK)

# Unit vectors v to the viewer, with n·v; the axis to the viewer.
VX, VY, VZ, FACING, AX, AY, AZ = range(14 * BLOCK, 21 * BLOCK, BLOCK)

# Ways D to a light or to the eye, with 1/|D|. Where |D| itself was wanted, it stands in the row of strengths.
DX, DY, DZ, NEARNESS = range(21 * BLOCK, 25 * BLOCK, BLOCK)

# Points, unless they stand in float64 beside rows of float32.
PX, PY, PZ = range(25 * BLOCK, 28 * BLOCK, BLOCK)

# Not 0 for a vertex that is left to the reference.
DECLINED = 28 * BLOCK

# Albedo.
ALBEDO_R, ALBEDO_G, ALBEDO_B = range(29 * BLOCK, 32 * BLOCK, BLOCK)

# How a light with a size is seen: sine and cosine of its angular radius, n·l; for its stage's own use.
SINE, COSINE, TILT, OWN = range(32 * BLOCK, 36 * BLOCK, BLOCK)

# Arcs of great circles, and rims, along which integrals over lights with a size are taken.
ARC, RIM = OWN + 8 * BLOCK, OWN + 14 * BLOCK

# Parts of one light, and of the ambient light, that nothing blocks.
VISIBLE, SKY = range(RIM + 16 * BLOCK, RIM + 18 * BLOCK, BLOCK)

# Unit tangents across n, where the reflectance needs them; and the length of all rows.
TX, TY, TZ, ROWS = range(RIM + 18 * BLOCK, RIM + 22 * BLOCK, BLOCK)

# What threads that light the same vertices share: how many are at it, how often one of them had to leave vertices to
# the reference; then for each range of vertices, of which there are as many as threads, how many were begun with.
AT_WORK, LEFT, BEGUN = range(3)
