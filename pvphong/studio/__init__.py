"""Lit meshes and lights in a window: the implementation of `plotter.phong`.

`window_lights` represents the lights of a renderer as values, `lit_mesh` one lit mesh, `lit_actors` all lit meshes of a
renderer. `gathering` computes the light that bounces between meshes, `refining` the refined picture of one mesh, and
`background` runs both in threads. `gizmos` places lights by hand. `subplot` combines all of these. `live` has the
handles with which scripts change lights and materials, `keywords` reads the keywords of PyVista's `add_mesh`, and `web`
shows a plotter in a web page.
"""
