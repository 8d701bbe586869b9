"""Comparison of pvphong's colours with VTK's own lighting.

Read `validation` first: `validate`, which compares every vertex with VTK's own shader, and its result. `images`
compares rendered images pixel by pixel. `cases` is a fixed list of scenes, and `report` compares all of them.
"""
