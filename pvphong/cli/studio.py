"""`pvphong studio`: a lit mesh in a web page, with panels for its lights, materials and scene."""

from __future__ import annotations

import signal
from pathlib import Path

import pyvista as pv

from pvphong.base import check
from pvphong.cli.options import SIZE, Flag, Lighting, seeing
from pvphong.cli.view import BACKGROUND, set_scene
from pvphong.meshes.pictures import drawing_window, preferring
from pvphong.studio.web import refuse_missing_extra


def studio(
    mesh: str | None = None,
    /,
    *,
    scene: Path | None = None,
    port: int = 0,
    host: str = "127.0.0.1",
    no_browser: Flag = False,
    keep: Flag = False,
) -> None:
    """Light a mesh in the browser: its lights, material and scene in panels, gizmos in its view; Ctrl-C ends it.

    Parameters
    ----------
    mesh
        A file of any format that PyVista reads. Without one, the page offers examples, and takes files.
    scene
        Lights, viewer, light model, materials, as Scene.save writes them (JSON).
    port
        The port to listen on; 0 is one that is free.
    host
        The address to listen on. By default this machine serves itself alone; for any other the page's address ends
        with a token, without which nothing is answered.
    no_browser
        Do not open a browser; the page's address is printed alone on the last line.
    keep
        Keep the rig beside the mesh, in NAME-rig.json, as it is edited, and begin with it if it is there.
    """
    refuse_missing_extra("pvphong studio")
    from pvphong.studio.web.serving import free_port

    port = free_port(host, port)  # refused before anything is read
    for option, given in (("--scene", scene), ("--keep", keep or None)):
        if mesh is None and given is not None:
            check.refuse(option, given, "left out without a mesh", "The page takes rigs, and gives them.")
    kept = Path(mesh).with_name(f"{Path(mesh).stem}-rig.json") if mesh is not None and keep else None
    if kept is not None and scene is None and kept.exists():
        scene = kept
    with preferring(drawing_window()):
        plotter = pv.Plotter(off_screen=True, window_size=list(SIZE), lighting="none")
    plotter.set_background(BACKGROUND)
    if mesh is not None:
        outside, rig, material = Lighting(scene=scene).read(mesh)
        rig = seeing(rig, outside, SIZE)
        set_scene(plotter, rig)
        plotter.phong.add_mesh(outside, material)
        plotter.reset_camera_clipping_range()
    if hasattr(signal, "SIGPIPE"):  # a browser that goes in the middle of a frame does not end this, as a pipe's reader
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    plotter.phong.studio(file=mesh or "mesh", port=port, host=host, browser=not no_browser, keep=kept)
