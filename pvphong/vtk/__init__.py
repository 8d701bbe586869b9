"""VTK's lighting: its lights, its shader, and where the two can be compared with pvphong's. In reading order:

`lights` takes over VTK's and PyVista's lights, and makes them; `scenes` says what VTK cannot draw, and how it is given
the rest; `oracle` runs VTK's own shader once per vertex; `rounding` says which vertices its float32 leaves open.
"""
