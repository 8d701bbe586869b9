"""Mouse and keyboard of a plotter without a window: events go to VTK's interactor, as a window would send them."""

import numpy as np


class Mouse:
    """The pointer of one plotter."""

    def __init__(self, plotter):
        self.plotter = plotter
        self.interactor = plotter.iren.interactor

    def at(self, point):
        """Pixels of a point of the world, in the active subplot."""
        renderer = self.plotter.renderer
        renderer.SetWorldPoint(*point, 1.0)
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

    def release(self, pixel, **modifiers):
        self.send("LeftButtonReleaseEvent", pixel, **modifiers)

    def drag(self, pixel, by, **modifiers):
        """Press, move in two steps, release; gives where it ended."""
        end = np.round(pixel) + by
        self.press(pixel)
        self.move(np.round(pixel) + 0.5 * np.array(by), **modifiers)
        self.move(end, **modifiers)
        self.release(end, **modifiers)
        return end

    def key(self, symbol, *, control=False):
        x, y = self.interactor.GetEventPosition()
        self.interactor.SetEventInformation(x, y, int(control), 0, "\0", 0, symbol)
        self.interactor.InvokeEvent("KeyPressEvent")
        self.interactor.InvokeEvent("CharEvent")
        self.interactor.InvokeEvent("KeyReleaseEvent")
