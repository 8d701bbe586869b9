"""Where a block's values stand in the kernel's scratch memory: row after row in one flat array."""

from __future__ import annotations

# Vertices in a block: a multiple of every vector's length, and few enough that the rows in use stay in 32 KiB
# of first-level cache.
BLOCK = 128

# Vertices per unit of parallel work: enough that its scratch memory costs nothing.
GROUP = 32 * BLOCK

# Bytes in a line of the processor's caches, and in its longest vectors.
LINE = 64

# Colour; and the part of it that the albedo does not multiply, where there is an albedo.
R, G, B, HR, HG, HB = range(0, 6 * BLOCK, BLOCK)

# Factors of one light: max(n·l, 0); the highlight's squared chord and then its power; attenuation times spot factor.
COSINE, SHINE, STRENGTH = range(6 * BLOCK, 9 * BLOCK, BLOCK)

# Points p; normals n, with 1/|n|.
PX, PY, PZ, NX, NY, NZ, INVERSE = range(9 * BLOCK, 16 * BLOCK, BLOCK)

# Unit vectors v to the viewer, with n·v; the axis to the viewer.
VX, VY, VZ, FACING, AX, AY, AZ = range(16 * BLOCK, 23 * BLOCK, BLOCK)

# Ways D to a light or to the eye, with 1/|D|, and with the powers of two that were taken out of them where any of
# them was rescued.
DX, DY, DZ, NEARNESS, EXPONENT = range(23 * BLOCK, 28 * BLOCK, BLOCK)

# Albedo; and the length of all rows.
ALBEDO_R, ALBEDO_G, ALBEDO_B, ROWS = range(28 * BLOCK, 32 * BLOCK, BLOCK)
