"""Geometry of the viewing pipeline: normals, matrices and coordinates, without lighting.

In the order of a renderer's stages:

- surface normals: `face_normals` and `vertex_normals` for meshes, `plane_normal` for planes, `implicit_normals` for
  implicit surfaces;
- object to world: `transform_points`, `transform_vectors`, `transform_normals`, and `normal_matrix` for the matrix that
  transforms normals;
- light from homogeneous coordinates: `light_from_homogeneous`;
- world to eye: `look_at`;
- eye to clip: `perspective`, `frustum`, `ortho`;
- world to window in one step, for a viewer: `project`.

Matrices are (4, 4) and multiply column vectors.
"""

from pvphong.geometry.projection import (
    frustum,
    implicit_normals,
    look_at,
    ortho,
    perspective,
    plane_normal,
    project,
)
from pvphong.geometry.transform import normal_matrix, transform_normals, transform_points, transform_vectors
from pvphong.meshes.surfaces import face_normals, vertex_normals
from pvphong.optics.lights import light_from_homogeneous

__all__ = [
    "face_normals",
    "frustum",
    "implicit_normals",
    "light_from_homogeneous",
    "look_at",
    "normal_matrix",
    "ortho",
    "perspective",
    "plane_normal",
    "project",
    "transform_normals",
    "transform_points",
    "transform_vectors",
    "vertex_normals",
]
