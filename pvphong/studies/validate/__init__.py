"""pvphong's colours against VTK's own lighting.

Read `validation` first: `validate`, which compares every vertex with VTK's own shader, and its result. `images`
compares what is drawn pixel by pixel. `cases` is a fixed list of scenes, and `report` compares all of them.
"""
