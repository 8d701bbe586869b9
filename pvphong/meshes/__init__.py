"""PyVista data in and out: `lit.py` is what `mesh.phong.shade` and `mesh.phong.plan` run."""
