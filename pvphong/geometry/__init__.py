"""What is known of meshes as plain arrays, before any light.

`transform.py`: points, vectors and normals under model matrices, and exact arithmetic; `normals.py`: normals and
tangents of meshes; `fit.py`: how stored normals fit the faces; `projection.py`: the viewing pipeline, and normals of
planes and of implicit surfaces; `extent.py`: where vertices are and where they look, for plans, and whether they bound
a convex body; `rays.py`: rays from far away.
"""
