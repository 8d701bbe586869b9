"""Lights and materials, one file each."""
