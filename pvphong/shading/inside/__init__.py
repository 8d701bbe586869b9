"""What colours do between vertices, and what is done about it.

In reading order: `interpolation` finds where they are off; `triangles` are bisected and cut, as index arrays; `surface`
has their lit vertices; `cutting` finds edges of shadows and cones, and cuts there; `splitting` splits the rest.
"""
