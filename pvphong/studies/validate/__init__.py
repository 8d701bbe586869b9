"""Comparison of pvphong's colours with VTK's own lighting.

- `validation`: `validate`, which compares every vertex with VTK's own shader, and its result. Read it first.
- `images`: compares rendered images pixel by pixel.
- `cases`: a fixed list of scenes.
- `report`: compares all of these scenes.
"""
