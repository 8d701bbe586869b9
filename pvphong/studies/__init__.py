"""Studies of a mesh and its colours.

`diagnose` says what in a mesh will not light as it should, `validate` compares colours with VTK's own shader, `refine`
splits triangles where blended colours miss the lit ones, and `accuracy` measures what all of that costs in time. They
do not depend on each other, but `accuracy` refines meshes and draws the frames of `validate`.
"""
