"""Integrals over the visible part of an area light and over environments, each as one formula.

In reading order:

- `lobes`: integrals of powers of a cosine over a region of the unit sphere, along its boundary.
- `polygon`: integrals along a polygon's sides.
- `disk`: integrals along a disk's rim; a sphere is seen as a disk.
- `harmonics`: expansion of a sky in bands of spherical harmonics.
- `sampling`: choice of points on lights, to which rays are cast.
- `patches`: division of the sky into patches.
"""
