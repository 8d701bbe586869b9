"""Lit meshes and lights in a window, as `plotter.phong` has them.

`window_lights` has the lights of a renderer as values, `lit_actors` its lit meshes, `gathering` the light that bounces
between them, `refining` their refined pictures, `background` the threads in which both are computed; `gizmos` what
places lights by hand; `subplot` puts all of it together. `web` has it in a web page.
"""
