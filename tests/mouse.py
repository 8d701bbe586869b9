"""Mouse and keyboard of a plotter without a window: events go to VTK's interactor, as a window would send them."""

import numpy as np


def picture(plotter):
    """What the window shows after a new frame, gizmos included."""
    plotter.render()
    return plotter.image.astype(int)


def texts(plotter):
    """VTK's texts on the screen, after a new frame."""
    plotter.render()
    return [prop for prop in plotter.renderer.GetViewProps() if prop.IsA("vtkTextActor") and prop.GetVisibility()]


class Mouse:
    """The pointer of one plotter, and what it points at there."""

    def __init__(self, plotter):
        self.plotter = plotter
        self.interactor = plotter.iren.interactor

    def gizmo(self, name):
        """The gizmo of a light, by the light's name."""
        return next(each for each in self.plotter.phong.gizmos if each.light.name == name)

    def at(self, *point):
        """Pixels, in the active subplot, of a point of the world or of a light's handle."""
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
        """Press, move in two steps, release; gives where it ended."""
        end = self.pull(pixel, by, **modifiers)
        self.release(end, **modifiers)
        return end

    def pull(self, pixel, by, **modifiers):
        """A drag without its end."""
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
