"""Lit meshes and lights in a window: the implementation of `plotter.phong`.

- `window_lights`: the lights of a renderer, as pvphong's lights and VTK's.
- `lit_mesh`: one lit mesh. `lit_actors`: all lit meshes of a renderer.
- `softening`: shadows that grow finer while nothing moves.
- `gathering`: light that bounces between meshes. `refining`: the refined picture of one mesh. `background`: the threads
  in which both are computed. `coarse`: pictures of large meshes while something moves.
- `gizmos`: handles in the window that place lights by hand.
- `subplot`: one renderer with all of these.
- `readings`: the subplots of a plotter, and measurements of what they show. `histogram`: of the displayed luminance.
  `probing`: each light's share of a vertex.
- `live`: objects with which scripts change lights and materials.
- `outputs`: pictures and exports of a plotter.
- `keywords`: the keywords of PyVista's `add_mesh`.
- `web`: a plotter in a web page.
"""
