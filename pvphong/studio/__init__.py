"""Lit meshes and lights in a window, as `plotter.phong` has them.

`window_lights` has the lights of a renderer as values, `lit_actors` its lit meshes, `gizmos` what places lights by
hand; `subplot` puts the three together. `web` has all of it in a web page.
"""
