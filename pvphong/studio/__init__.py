"""Lit meshes and lights in a window."""
