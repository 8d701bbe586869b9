"""The studio: lights, materials and light model of a plotter edited in a web page. Needs the extra `trame`.

Read in this order:

1. `fields`: what a form asks of a dataclass: kind, unit, range and help of each field; and a value from the page.
2. `document`: what is edited, by keys, with one history for panels and gizmos.
3. `page`: Vuetify's components around the view.
4. `door`: who gets in, by HTTP and WebSocket; which messages are taken; uploads.
5. `take_home`: the files that leave, and the Python that makes them again.
6. `studio`: the five put together, and the server.
7. `serving`: in a loop of its own, or in a notebook's.

The first two know nothing of a server.
"""
