"""Lit meshes and lights in a window, as `plotter.phong` has them.

`window_lights` has the lights of a renderer as values, `lit_mesh` one lit mesh, `gathering` the light that bounces
between several, `refining` the refined picture of one, `background` the threads in which both are computed,
`lit_actors` all lit meshes of a renderer; `gizmos` what places lights by hand; `subplot` puts all of it together;
`live` has the handles by which scripts change lights and materials, `keywords` reads what PyVista's `add_mesh` takes.
`web` has it in a web page.
"""
