"""Studios without a server, for tests."""

import asyncio
import inspect


def in_a_studio(plotter, act, *, file="part.vtm", **options):
    """Return the result of a function for a studio that is not served, on the plotter's active subplot.

    The function may be asynchronous.
    """
    from pvphong.studio.web.studio import Studio

    async def run():
        phong = plotter.phong
        if not phong.gizmos:
            phong.add_gizmos()
        result = act(Studio(plotter, phong._subplot, phong._history, file=file, **options))
        return await result if inspect.isawaitable(result) else result

    return asyncio.run(run())
