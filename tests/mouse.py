"""Mouse and keyboard of a plotter without a window. Events go to VTK's interactor, as from a window."""

import numpy as np


def picture(plotter):
    """Return the picture after a new frame, including gizmos."""
    plotter.render()
    return plotter.image.astype(int)


def texts(plotter):
    """Return VTK's texts on the screen after a new frame."""
    plotter.render()
    return [prop for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor") and prop.GetVisibility()]


class Mouse:
    """Pointer of one plotter, and positions to point at."""

    def __init__(self, plotter):
        self.plotter = plotter
        self.interactor = plotter.iren.interactor

    def gizmo(self, name):
        """Return a gizmo by its light's name."""
        return next(each for each in self.plotter.phong.gizmos if each.light.name == name)

    def at(self, *point):
        """Return the pixel of a world point or of a light's handle, in the active subplot."""
        if isinstance(point[0], str):
            name, handle = point
            point = (self.gizmo(name).handles[handle],)
        renderer = self.plotter.renderer
        renderer.SetWorldPoint(*point[0], 1.0)
        renderer.WorldToDisplay()
        return np.array(renderer.GetDisplayPoint()[:2])

    def send(self, event, pixel, *, shift=False, control=False):
        x, y = (round(float(value)) for value in pixel)
        self.interactor.SetEventInformation(x, y, int(control), int(shift), "\0", 0, "")
        self.interactor.InvokeEvent(event)

    def move(self, pixel, **modifiers):
        self.send("MouseMoveEvent", pixel, **modifiers)

    def press(self, pixel, **modifiers):
        self.move(pixel)
        self.send("LeftButtonPressEvent", pixel, **modifiers)

    def release(self, pixel=None, **modifiers):
        pixel = self.interactor.GetEventPosition() if pixel is None else pixel
        self.send("LeftButtonReleaseEvent", pixel, **modifiers)

    def click(self, pixel):
        self.press(pixel)
        self.release(pixel)

    def drag(self, pixel, by, **modifiers):
        """Press, move in two steps, and release. Return the last position."""
        end = self.pull(pixel, by, **modifiers)
        self.release(end, **modifiers)
        return end

    def pull(self, pixel, by, **modifiers):
        """Begin a drag, without releasing."""
        end = np.round(pixel) + by
        self.press(pixel)
        self.move(np.round(pixel) + 0.5 * np.array(by), **modifiers)
        self.move(end, **modifiers)
        return end

    def key(self, symbol, *, control=False):
        x, y = self.interactor.GetEventPosition()
        self.interactor.SetEventInformation(x, y, int(control), 0, "\0", 0, symbol)
        for event in ("KeyPressEvent", "CharEvent", "KeyReleaseEvent"):
            self.interactor.InvokeEvent(event)
