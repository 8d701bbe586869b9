"""PyVista data in and out.

`lit.py` is what `mesh.phong.shade` and `mesh.phong.plan` run, from top to bottom: `surfaces` (with `cells`, which
refuses what would crash VTK), `point_data`, `default_scene`, `visibility`. `blocks` does the same for meshes of several
blocks, `files` reads and writes them (`whole_files` says whether a file is whole), `pictures` draws them.
"""
