"""Meshes split where interpolated colours miss the lit ones."""
