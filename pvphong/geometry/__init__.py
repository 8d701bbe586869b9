"""Geometry of meshes as plain arrays, without lights.

- `transform.py`: points, vectors and normals under model matrices, and exact arithmetic.
- `normals.py`: normals and tangents of meshes.
- `fit.py`: comparison of stored normals with the faces.
- `projection.py`: the viewing pipeline, and normals of planes and implicit surfaces.
- `extent.py`: bounds of vertices and normals, which plans use, and a test for convex bodies.
- `rays.py`: moves the starts of rays that begin far away near the triangles.
"""
