"""VTK's lighting: its lights, its shader, and the limits of comparing it with pvphong. In reading order:

- `lights`: conversion of lights from and to VTK and PyVista.
- `scenes`: refuses scenes that VTK cannot draw, and converts others so that VTK draws them in the same colours.
- `oracle`: VTK's shader, run once per vertex.
- `rounding`: vertices where float32 leaves VTK's colour uncertain.
"""
