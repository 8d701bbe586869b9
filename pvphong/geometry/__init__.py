"""Points, normals and matrices, without any light."""
