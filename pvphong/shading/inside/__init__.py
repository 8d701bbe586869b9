"""Colours between vertices: errors of interpolation, and triangles that are split or cut where they are large.

In reading order: `lighting` is what is compared there, `places` where that is looked at, and `interpolation` finds
where it is off; `triangles` are bisected and cut, as index arrays; `surface`
has their lit vertices; `cutting` finds edges of shadows and cones, and cuts there; `splitting` splits the rest.
"""
