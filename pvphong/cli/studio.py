"""`pvphong studio`: show a lit mesh in a web page, with panels for its lights, materials and scene."""

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
    """Light a mesh in the browser: panels for lights, material and scene, gizmos in the view; Ctrl-C stops it.

    Parameters
    ----------
    mesh
        File of any format that PyVista reads. Without a file, the page offers examples and can open files.
    scene
        Rig file (JSON) with lights, viewer, light model and materials, as Scene.save writes it.
    port
        Port to listen on; 0 selects a free one.
    host
        Address to listen on. By default only this machine can connect. With any other host, the page's address ends
        with a token, and requests without the token get no answer.
    no_browser
        Do not open a browser. The page's address is the last line that is printed.
    keep
        Save each edit of the rig in NAME-rig.json next to the mesh, and start from that file if it exists.
    """
    refuse_missing_extra("pvphong studio")
    from pvphong.studio.web.serving import free_port

    port = free_port(host, port)  # raises before any file is read
    for option, given in (("--scene", scene), ("--keep", keep or None)):
        if mesh is None and given is not None:
            check.refuse(option, given, "used with a mesh file", "Without a mesh file, load and save rigs in the page.")
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
    if hasattr(signal, "SIGPIPE"):  # a browser may disconnect while a frame is sent, which must not end the server
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    plotter.phong.studio(file=mesh or "mesh", port=port, host=host, browser=not no_browser, keep=kept)
