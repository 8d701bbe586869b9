"""Studies of a mesh and its colours.

`diagnose` finds faults of a mesh that spoil its lighting. `validate` compares colours with VTK's own shader. `refine`
splits triangles whose interpolated colours differ from evaluated ones. `fitting` finds lights from the colours that a
mesh should have. `accuracy` measures errors and times. The five studies are independent of each other, except that
`accuracy` uses `refine` and the windows of `validate`.
"""
