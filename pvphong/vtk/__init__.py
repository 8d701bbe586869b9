"""VTK's lighting: its lights, its shader, and the limits of comparing it with pvphong. In reading order:

`lights` converts lights from and to VTK and PyVista; `scenes` refuses scenes that VTK cannot draw, and converts others
to VTK's terms; `oracle` runs VTK's shader once per vertex; `rounding` finds vertices whose colour float32 decides.
"""
