"""The studio: a plotter's lights, materials and scene in a web page, with the same gizmos in its view.

Here a page is served for a moment, two edits are made as its panels make them, and one is undone. With `--window` a
browser opens, and Ctrl-C ends the script; `pvphong studio part.stl` does that for a file. In Jupyter,
`plotter.phong.studio()` shows the page below the cell. It needs the extra `trame`.
"""

import asyncio

import pyvista as pv
from arguments import FOLDER, WINDOW

import pvphong as ph

plotter = pv.Plotter(off_screen=True, window_size=(640, 400), lighting="none")
plotter.set_background("#2b2e34")
knot = pv.ParametricTorus(ringradius=0.6, crosssectionradius=0.25, u_res=300, v_res=160)
plotter.phong.add_mesh(knot, ph.Material(diffuse=(0.55, 0.5, 0.45), reflectance=ph.GGX(roughness=0.35)), name="torus")
plotter.phong.add_light(ph.DirectionalLight(direction=(1, -0.6, -1), intensity=0.8, frame="camera", name="key"))
plotter.phong.add_light(
    ph.RectangleLight(
        position=(-1.6, -0.6, 0.9), direction=(1.6, 0.6, -0.9), width=0.4, height=1.6, intensity=3, name="softbox"
    )
)
plotter.camera_position = [(0, -3.4, 2.2), (0, 0, 0), (0, 0, 1)]
plotter.phong.light_model = ph.LightModel(ambient=0.1, shadows=True)


async def serve_for_a_moment() -> None:
    """What a notebook does: the page is served by the loop that runs already."""
    page = plotter.phong.studio(file="torus.vtp")
    document = page.studio.document
    document.edit("light.2.diffuse", "orange")  # as the colour's field does
    document.edit("light.1.intensity", "0.1")
    document.undo()
    await page.close()
    print(page.studio.downloads.script())


if WINDOW:
    plotter.phong.studio(file="torus.vtp")
else:
    asyncio.run(serve_for_a_moment())
picture = FOLDER / "studio.png"
plotter.screenshot(picture)
print(f"wrote {picture}")
plotter.close()
