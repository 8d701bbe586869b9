"""Geometry of meshes as plain arrays, without lights.

- `transform.py`: points, vectors and normals under model matrices, and exact arithmetic.
- `normals.py`: normals and tangents of meshes.
- `fit.py`: comparison of stored normals with the faces.
- `projection.py`: the viewing pipeline, and normals of planes and implicit surfaces.
- `extent.py`: bounds of vertices and normals, and a test for convex bodies.
- `rays.py`: if a ray begins far away, moves its start near the triangles.
"""
