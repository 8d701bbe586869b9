"""Integrals over the visible part of an area light and over environments, each as one formula.

Read `lobes` first: powers of a cosine over a region of the unit sphere, as integrals along its boundary. `polygon` and
`disk` integrate along sides and rims; a sphere is seen as a disk. `harmonics` expands a sky in bands. `sampling`
chooses points on lights for rays.
"""
