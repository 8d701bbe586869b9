"""
The studio
==========

Edit a plotter's lights, materials and scene in a web page. Panels and gizmos edit the same lights, every edit is one
step of undo, and the page writes a Python script that makes the same result.
"""

import asyncio

import pyvista as pv

import pvphong as ph

# %%
# A plotter with lights
# ---------------------
# The studio takes any plotter that has lit meshes and lights.


def stage() -> pv.Plotter:
    """Return a plotter with a torus, a key light and a softbox."""
    plotter = pv.Plotter(off_screen=True, window_size=(900, 560), lighting="none")
    plotter.set_background("#2b2e34")
    torus = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.25, u_res=240, v_res=120)
    grey = ph.Material(diffuse=(0.55, 0.5, 0.45), reflectance=ph.GGX(roughness=0.35))
    plotter.phong.add_mesh(torus, grey, name="torus")
    plotter.phong.add_light(ph.DirectionalLight(direction=(1, -0.6, -1), intensity=0.8, frame="camera", name="key"))
    plotter.phong.add_light(
        ph.RectangleLight((-1.6, -0.6, 0.9), (1.6, 0.6, -0.9), width=0.4, height=1.6, intensity=3, name="softbox")
    )
    plotter.camera_position = [(0, -3.0, 2.0), (0, 0, 0), (0, 0, 1)]
    plotter.phong.light_model = ph.LightModel(ambient=0.1, shadows=True)
    return plotter


# %%
# Open the page
# -------------
# ``plotter.phong.studio()`` takes the place of ``plotter.show()``: it opens a browser, and returns on Ctrl-C. In
# Jupyter it shows the page below the cell. For a file, ``pvphong studio part.stl`` does it on the command line.

if not pv.OFF_SCREEN:
    stage().phong.studio(file="torus.vtp")

# %%
# What an edit does
# -----------------
# Inside a running event loop, as in a notebook, ``studio`` returns the page at once. Here the page is served for a
# moment, and two fields are edited as if in its panels. The second edit is undone.


async def edit(plotter: pv.Plotter) -> str:
    """Serve the page, edit two fields, undo one, and return the page's script."""
    page = plotter.phong.studio(file="torus.vtp")
    document = page.studio.document
    document.edit("light.2.diffuse", "orange")
    document.edit("light.1.intensity", "0.1")
    document.undo()
    await page.close()
    return page.studio.downloads.script()


plotter = stage()
script = asyncio.run(edit(plotter))
plotter.show()

# %%
# Take the script home
# --------------------
# The page's *Files* panel offers this script. It makes the same lit mesh without the studio.

print(script)
