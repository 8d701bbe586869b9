"""A plotter in a real window, for tests that move the mouse from outside.

Run as a program it opens the window and answers commands, one a line, with one line of JSON each, after it has
dealt with all events that the window has got. Imported, it gives the test's side of that.
"""

import hashlib
import json
import os
import subprocess
import sys
import time

SIZE = (640, 480)


class Program:
    """Plotter in a separate process, which answers commands."""

    def __init__(self, *command, environment=None):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._child = subprocess.Popen([sys.executable, "-W", "error", *command], env=environment, **pipes)

    def answer(self):
        answer = self._child.stdout.readline()
        assert answer, f"the plotter's process ended: {self._child.wait(10)}"
        return json.loads(answer)

    def ask(self, command="state"):
        """Send a command and return the plotter's answer."""
        self._child.stdin.write(command + "\n")
        self._child.stdin.flush()
        return self.answer()

    def wait(self, until=lambda _: True):
        """Repeat a command until a condition holds, since events arrive late. Return the last answer."""
        for _ in range(300):
            state = self.ask()
            if until(state):
                return state
            time.sleep(0.03)
        raise AssertionError(f"it did not come: {state}")

    def close(self):
        """End the process and return its exit status."""
        with self._child as child:  # closes its pipes, then waits
            child.stdin.close()
            return child.wait(20)


class Window(Program):
    """A window, and the mouse as the X server moves it."""

    def __init__(self, environment):
        super().__init__(__file__, environment=environment)
        self._environment = environment
        self.ask()
        self._at = None
        self._id = self._xdotool("search", "--name", "pvphong in a window").split()[-1]

    def _xdotool(self, *words):
        done = subprocess.run(["xdotool", *words], env=self._environment, capture_output=True, text=True, timeout=20)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def point(self, pixel):
        """Move the pointer to a pixel, counted from below as in VTK."""
        at = str(round(pixel[0])), str(SIZE[1] - 1 - round(pixel[1]))
        if at != self._at:  # xdotool would wait for the movement without a limit
            self._xdotool("mousemove", "--sync", "--window", self._id, *at)
        self._at = at

    def do(self, *words, until=lambda _: True):
        """Run another mouse or keyboard action."""
        self._xdotool(*words)
        return self.wait(until)

    def drag(self, start, by, *, modifier=None):
        """Press, move in steps, and release. Return the plotter's state before and after the release."""
        self.point(start)
        self.wait(lambda state: state["hovered"])
        if modifier:
            self.do("keydown", modifier)
        self.do("mousedown", "1")
        for part in (0.25, 0.5, 0.75, 1.0):
            self.point([round(s) + part * b for s, b in zip(start, by, strict=True)])
            self.wait()
        held = self.wait(lambda state: state["dragging"])
        self.do("mouseup", "1")
        if modifier:
            self.do("keyup", modifier)
        return held, self.wait(lambda state: not state["dragging"])


def essence(state):
    """Return the state that a drag may change and undo restores."""
    return {key: state[key] for key in ("lights", "guest", "colors", "camera")}


def furnish(plotter):
    """A ball in the light of a lamp, a spot light, and a guest of PyVista's; gives the ball's actor and the guest."""
    import pyvista as pv

    import pvphong as ph

    plotter.set_background("#30343c")
    guest = pv.Light(position=(-0.2, -1.0, 1.3), focal_point=(0, 0, 0.2), color="skyblue", light_type="scene light")
    guest.positional, guest.cone_angle, guest.intensity = True, 14.0, 0.6
    lamp = ph.PointLight((0.9, -0.5, 0.6), attenuation=(1, 0, 6), diffuse=(1, 0.5, 0.2), name="lamp")
    plotter.phong.add_light(lamp)
    spot = ph.SpotLight((-0.9, -0.3, 0.9), (0.8, 0.1, -0.8), cone_angle=18, diffuse=(0.5, 1, 0.5), name="spot")
    plotter.phong.add_light(spot)
    plotter.add_light(guest)
    material = ph.Material(ambient=0.15, diffuse=0.7, specular=0.4, shininess=30)
    actor = plotter.phong.add_mesh(pv.Sphere(theta_resolution=80, phi_resolution=80), material)
    plotter.camera_position = [(0, -5, 2.5), (0, 0, 0.2), (0, 0, 1)]
    plotter.phong.add_gizmos()
    return actor, guest


def told(plotter, actor, guest):
    """Return the state of a furnished plotter that tests check."""
    import numpy as np

    from pvphong.studio.gizmos.interaction import Drag, Entry

    interaction, gizmos = plotter.phong._subplot.interaction, plotter.phong.gizmos
    view, edit = interaction.gizmos.view, interaction.edit
    colors = np.asarray(actor.mapper.dataset["phong"])
    return {
        "size": view.size,
        "cursor": plotter.iren.interactor.GetEventPosition(),
        "ball": view.project((0, 0, 0)).tolist(),
        "handles": [{n: view.project(p).tolist() for n, p in gizmo.handles.items()} for gizmo in gizmos],
        "highlight": [None if g.highlight is None else view.project(g.highlight).tolist() for g in gizmos],
        "lights": [repr(light) for light in plotter.phong.lights],
        "cones": [getattr(light, "cone_angle", None) for light in plotter.phong.lights],
        "guest": [guest.position, guest.focal_point, guest.cone_angle],
        "colors": hashlib.sha256(np.ascontiguousarray(colors)).hexdigest(),
        "hovered": next((gizmo.hovered for gizmo in gizmos if gizmo.hovered), None),
        "dragging": isinstance(edit, Drag),
        "typing": edit.text if isinstance(edit, Entry) else "",
        "selected": [gizmo.is_selected for gizmo in gizmos],
        "camera": list(plotter.camera.position),
    }


def end_at_errors():
    """End the process at an error in a callback; VTK would only print it."""

    def end(*error):
        sys.__excepthook__(*error)
        os._exit(1)

    sys.excepthook = end


def main():
    """The plotter's side."""
    import pyvista as pv

    end_at_errors()
    pv.global_theme.multi_samples = 1  # eight take a processor four times as long
    plotter = pv.Plotter(window_size=SIZE, lighting="none", title="pvphong in a window")
    actor, guest = furnish(plotter)
    plotter.show(interactive_update=True, auto_close=False)
    for line in sys.stdin:
        if (command := line.strip()) in ("undo", "redo"):
            getattr(plotter.phong, command)()
        plotter.iren.process_events()
        print(json.dumps(told(plotter, actor, guest)), flush=True)
    plotter.close()


if __name__ == "__main__":
    main()
