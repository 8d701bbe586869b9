"""Access to the studio: who gets in, by HTTP and by WebSocket, which messages are taken, and how files come in.

Served on this machine alone, whoever is on it may come in, but no page of another origin. Served to others, everything
lies in a folder whose name is a token, and nothing else is answered. A cookie would not do: browsers send none for a
page in a frame of another host's, as in a notebook.

Messages are what trame's page sends, and nothing else: each is checked before anything acts on it, and a malformed one
gets an answer that says so. VTK's adapter of remote events, for one, would end the process at a key that is missing.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import secrets
import tempfile
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import msgpack
from aiohttp import web
from wslink.backends.aiohttp import AioHttpWsHandler
from wslink.chunking import generate_chunks
from wslink.protocol import MAX_MSG_SIZE

from pvphong.base import check

_LARGEST_MESSAGE = 2**20
"""Bytes of a message; files come by HTTP."""
_FRAME = "publish:trame.rca.topic.stream:"
"""How the ids of messages with a picture of the view begin."""
_MOST_PENDING = 4
"""Messages of one client that may be incomplete."""
LARGEST_FILE = 2**28
"""Bytes of an uploaded file, 256 MiB."""
_PIECE = 2**16
_MOST_PIXELS = 4096  # of a view's side
_MOST_NESTED = 8
_LARGEST = 1e300  # number
_LONGEST = 2**16  # letters of a text, entries of a list

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


# --- who gets in


def is_loopback(host: str) -> bool:
    """Whether a name or an address to listen on is this machine's alone."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Access:
    """Which requests the studio's server answers.

    Parameters
    ----------
    host : str
        The address that the server listens on.
    """

    def __init__(self, host: str) -> None:
        self._is_local = is_loopback(host)
        self.token = "" if self._is_local else secrets.token_urlsafe(24)
        """The folder that all is in; "" where only this machine is served."""

    @property
    def root(self) -> str:
        """The path that all others begin with."""
        return f"/{self.token}/" if self.token else "/"

    def guard(self, app: web.Application) -> None:
        """Have every request of an application checked first, and all that it serves below the root."""
        app.middlewares.append(self._admit)
        if self.token:
            app.on_startup.append(self._move)  # when all routes are there

    async def _move(self, app: web.Application) -> None:
        for resource in app.router.resources():
            app.router.unindex_resource(resource)  # aiohttp finds it by its path
            resource.add_prefix(f"/{self.token}")
            app.router.index_resource(resource)

    @web.middleware
    async def _admit(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        if not self.admits(request.host, request.headers.get("Origin"), request.path):
            return web.Response(status=403)
        try:
            response = await handler(request)
        except web.HTTPException as answer:  # a redirection, or that there is no such page
            self._finish(answer)
            raise
        self._finish(response)
        return response

    @staticmethod
    def _finish(response: web.StreamResponse) -> None:
        """Have the browser tell nobody of the token."""
        if not response.prepared:
            response.headers["Referrer-Policy"] = "no-referrer"
            response.headers["X-Content-Type-Options"] = "nosniff"

    def admits(self, host: str, origin: str | None, path: str) -> bool:
        """Whether a request gets in.

        Parameters
        ----------
        host : str
            The `Host` that it names. On this machine it must be this machine's name, for a page of another name may
            have had that resolved to here.
        origin : str or None
            Of the page that it comes from; None where it comes from none.
        path : str
            What it asks for.
        """
        try:
            if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
                return False
            if self._is_local and not is_loopback(urlsplit(f"//{host}").hostname or ""):
                return False
        except ValueError:
            return False
        wanted = self.root.encode()
        return hmac.compare_digest(path.encode(errors="replace")[: len(wanted)], wanted)


# --- files that come in


async def receive(request: web.Request, suffixes: tuple[str, ...], folder: Path) -> tuple[str, Path]:
    """An uploaded file, written into a folder under a name of our own.

    Parameters
    ----------
    request : aiohttp.web.Request
        Its body is the file, its query's `name` what that is called, of which only the ending counts here.
    suffixes : tuple of str
        The endings that are allowed.
    folder : Path
        One for this file alone.

    Returns
    -------
    name : str
        Without folders.
    path : Path
        Where the file is.

    Raises
    ------
    ValueError
        If the name does not end so, the file is empty, or it is larger than `LARGEST_FILE`; of that no more is
        read.
    """
    name = request.query.get("name", "").replace("\\", "/").rpartition("/")[2][:200]
    suffix = Path(name).suffix.lower()
    if suffix not in suffixes:
        check.refuse("file", name or "one without a name", f"one that ends with {', '.join(suffixes)}")
    allowed = f"at most {LARGEST_FILE >> 20} MiB"
    if (request.content_length or 0) > LARGEST_FILE:
        check.refuse("file", f"{name}, {(request.content_length or 0) >> 20} MiB", allowed)
    path, size = folder / f"upload{suffix}", 0
    with path.open("wb") as file:
        async for piece in request.content.iter_chunked(_PIECE):
            size += len(piece)
            if size > LARGEST_FILE:
                check.refuse("file", f"{name}, which is larger", allowed)
            file.write(piece)
    if not size:
        check.refuse("file", f"{name}, which is empty", "one with something in it")
    return name, path


def upload(
    suffixes: tuple[str, ...],
    take: Callable[[str, Path, Mapping[str, str]], Awaitable[None]],
    done: Callable[[str], None],
) -> Handler:
    """A handler of uploads: files that end so are given to a function, and then removed.

    Parameters
    ----------
    suffixes : tuple of str
        The endings that are allowed.
    take : callable
        Takes name, path and the query; ValueError where it cannot.
    done : callable
        Told why a file was not taken, or "" when it was.
    """

    async def handle(request: web.Request) -> web.StreamResponse:
        reason = name = ""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder)
            try:
                name, path = await receive(request, suffixes, path)
                await take(name, path, request.query)
            except ValueError as error:
                reason = str(error).replace(str(path), name)
        done(reason)
        answer = web.Response(status=400 if reason else 204, text=reason or None)
        if reason:
            answer.force_close()  # the rest of what is too large is not read
        return answer

    return handle


# --- messages


class Malformed(ValueError):
    """A message that the studio's page does not send."""


_MOUSE = {f"{button}Button{what}" for button in ("Left", "Middle", "Right") for what in ("Press", "Release")}
_WHEEL = {"StartMouseWheel", "MouseWheel", "EndMouseWheel"}
_KEYS = {"KeyDown", "KeyPress", "KeyUp"}
_TOUCH = {f"{when}{what}" for what in ("Pinch", "Rotate", "Pan") for when in ("Start", "", "End")}
_TOUCH |= {"Tap", "LongTap"}
_MODIFIERS = ("shiftKey", "altKey", "ctrlKey", "metaKey")
_IDLE = {"StartInteractionEvent", "EndInteractionEvent"}


def view_event(given: Any) -> dict[str, Any]:
    """An event of mouse, wheel, keyboard or touch, as VTK's adapter may be given it: all keys there, all in range.

    Raises
    ------
    Malformed
        If it is none.
    """
    if not isinstance(given, dict) or not isinstance(given.get("type"), str):
        raise Malformed("an event has a type")
    kind = given["type"]
    if kind in _IDLE:
        return {"type": kind}
    if kind not in {"MouseMove", *_MOUSE, *_WHEEL, *_KEYS, *_TOUCH}:
        raise Malformed("no such event")
    event: dict[str, Any] = {"type": kind} | {name: int(bool(given.get(name))) for name in _MODIFIERS}
    event |= {name: _number(given.get(name, 0.0), -_MOST_PIXELS, _MOST_PIXELS) for name in "xywh"}
    if kind in _WHEEL:
        event["spinY"] = _number(given.get("spinY", 0.0), -100.0, 100.0)
    if kind in _KEYS:
        key = given.get("key", "")
        if not isinstance(key, str) or len(key) > 20 or not key.isprintable():
            raise Malformed("no such key")
        event |= {"key": key, "keyCode": int(_number(given.get("keyCode", 0), 0, 2**16))}
        event |= {name: bool(given.get(name)) for name in ("controlKey", "altKey", "shiftKey")}
    if kind in _TOUCH:
        event |= {"factor": _number(given.get("factor", 1.0), 1e-3, 1e3)}
        event |= {"rotation": _number(given.get("rotation", 0.0), -1e4, 1e4)}
        event["translation"] = [_number(each, -1e4, 1e4) for each in _list(given.get("translation", [0, 0]), 2)]
        positions = given.get("positions")
        positions = positions if isinstance(positions, dict) else {}
        if len(positions) > 10:
            raise Malformed("too many fingers")
        event["positions"] = {
            str(number): {axis: _number(place.get(axis, 0.0), -1e4, 1e4) for axis in ("x", "y")}
            for number, place in enumerate(positions.values())
            if isinstance(place, dict)
        }
    return event


def view_size(given: Any) -> dict[str, Any]:
    """The size of a view in a browser, as large as a window may be."""
    if not isinstance(given, dict):
        raise Malformed("a size has a width and a height")
    width, height = (_number(given.get(name, 0.0), 0.0, 1e6) for name in ("w", "h"))
    ratio = _number(given.get("p", 1.0), 0.1, 10.0)
    most = _MOST_PIXELS / ratio
    return {"w": min(width, most), "h": min(height, most), "p": ratio}


def _number(given: Any, least: float, most: float) -> float:
    if type(given) not in (int, float) or not least <= given <= most:  # so no NaN either
        raise Malformed("a number that is none, or out of range")
    return given


def _list(given: Any, count: int) -> list[Any]:
    if not isinstance(given, list) or len(given) != count:
        raise Malformed(f"a list has {count} entries")
    return given


def plain(given: Any, depth: int = 0) -> Any:
    """Plain values of moderate size: texts, numbers, flags, and lists of such."""
    if isinstance(given, list) and depth < _MOST_NESTED and len(given) <= _LONGEST:
        return [plain(each, depth + 1) for each in given]
    if given is None or (isinstance(given, int | float) and -_LARGEST <= given <= _LARGEST):
        return given
    if isinstance(given, str) and len(given) <= _LONGEST:
        return given
    raise Malformed("values are texts, finite numbers, flags and lists")


class Messages(AioHttpWsHandler):
    """The WebSocket's end here: takes what the studio's page sends, and answers anything else with an error.

    Parameters
    ----------
    protocol : wslink.websocket.ServerProtocol
        trame's.
    server : wslink's web server
        That of trame.
    triggers : mapping
        Name → function, of what the page may trigger, and nothing else.
    closed : callable
        Called when a client has gone, with whether it held the mouse's left button down in the view.
    """

    def __init__(
        self,
        protocol: Any,
        server: Any,
        triggers: Mapping[str, Callable[..., Any]],
        closed: Callable[[bool], None],
    ) -> None:
        super().__init__(protocol, server)
        self._triggers, self._closed = triggers, closed
        self._sizes: dict[str, dict[str, Any]] = {}
        self._shown_to = self._held_by = ""
        self._sending: dict[str, asyncio.Lock] = {}
        self._frames: dict[str, bytes] = {}

    async def onMessage(self, is_binary: bool, msg: Any, client_id: str) -> None:
        """A frame has come: a whole message, or a part of one."""
        pieces = self.unchunkers[client_id]
        try:
            if not is_binary:
                raise Malformed("frames are binary")
            message = pieces.process_chunk(msg.data)
            if len(pieces.pending_messages) > _MOST_PENDING:
                pieces.release_pending_messages()
                raise Malformed("too many messages at once")
            if message is not None:
                await self.onCompleteMessage(self._checked(message, client_id), client_id)
        except (ValueError, TypeError, IndexError, OverflowError, RecursionError, MemoryError):
            pieces.release_pending_messages()
            if not self.connections[client_id].closed:
                await self.sendWrappedError("malformed", -32600, "Malformed message", client_id=client_id)

    def _checked(self, message: Any, client_id: str) -> dict[str, Any]:
        """A message, if it is one of those that the page sends."""
        if not isinstance(message, dict) or not isinstance(message.get("id"), str) or len(message["id"]) > 200:
            raise Malformed("a message has an id")
        method, args = message.get("method"), message.get("args", [])
        if not isinstance(args, list) or message.get("kwargs"):
            raise Malformed("a message has a list of arguments")
        if message["id"].startswith("system:"):
            if method == "wslink.hello" and len(args) == 1 and isinstance(args[0], dict):
                return {"id": message["id"], "method": method, "args": args}
            raise Malformed("no such method")
        if not self.isClientAuthenticated(client_id):
            raise Malformed("the first message is a greeting")
        if method == "trame.trigger":
            name, given, named = (*args, {})[:3]
            if name not in self._triggers or named or not isinstance(given, list):
                raise Malformed("no such trigger")
            args = [name, plain(given), {}]
        elif method == "trame.rca.event":
            args = [*map(str, _list(args, 3)[:2]), view_event(args[2])]
            self._show_to(args[0], client_id)
            if args[2]["type"].startswith("LeftButton"):
                self._held_by = client_id if args[2]["type"].endswith("Press") else ""
        elif method == "trame.rca.size":
            args = [*map(str, _list(args, 3)[:2]), view_size(args[2])]
            self._sizes[client_id] = args[2]
            self._shown_to = client_id
        elif method == "trame.lifecycle.update":
            if args not in (["client_connected"], ["client_mounted"], ["client_exited"], ["client_unmounted"]):
                raise Malformed("no such event")
        elif method == "trame.rca.video.codecs":
            args = [str(_list(args, 1)[0])]
        elif method != "trame.state.get":
            raise Malformed("no such method")
        return {"id": message["id"], "method": method, "args": args}

    def _show_to(self, area: str, client_id: str) -> None:
        """Draw in the size of the browser that is being used, for several may look on in others."""
        size = self._sizes.get(client_id)
        if client_id != self._shown_to and size is not None:
            self._shown_to = client_id
            areas, resize = self.functionMap["trame.rca.size"]
            resize(areas, area, "access", size)

    async def handleSystemMessage(self, rpcid: str, methodName: str, args: list[Any], client_id: str) -> bool:
        """Greetings: wslink would then take messages of 4 GiB."""
        is_system: bool = await super().handleSystemMessage(rpcid, methodName, args, client_id)
        self.unchunkers[client_id].set_max_message_size(_LARGEST_MESSAGE)
        return is_system

    async def onConnect(self, request: web.Request, client_id: str) -> None:
        """A client has come."""
        self._sending[client_id] = asyncio.Lock()
        await super().onConnect(request, client_id)

    async def onClose(self, client_id: str) -> None:
        """A client has gone."""
        await super().onClose(client_id)
        for known in (self._sizes, self._sending, self._frames):
            known.pop(client_id, None)
        was_held = self._held_by == client_id
        if was_held:
            self._held_by = ""
        self._closed(was_held)

    async def sendWrappedMessage(
        self,
        rpcid: str,
        content: Any,
        method: str = "",  # noqa: ARG002 wslink's signature
        client_id: str | None = None,
        skip_last_active_client: bool = False,  # noqa: ARG002 nobody else's values are taken from a client
    ) -> None:
        """Send to one client; wslink would have all wait for the slowest.

        Of frames that one has not got yet, it gets the last.
        """
        if client_id is None or not self.isClientAuthenticated(client_id):
            return
        packed = msgpack.packb({"wslink": "1.0", "id": rpcid, "result": content})
        if not rpcid.startswith(_FRAME):
            await self._send(client_id, packed)
            return
        is_sent = client_id not in self._frames
        self._frames[client_id] = packed
        while is_sent and client_id in self._frames:
            last = self._frames[client_id]
            await self._send(client_id, last)
            if self._frames.get(client_id) is last:
                del self._frames[client_id]

    async def sendWrappedError(
        self,
        rpcid: str,
        code: int,
        message: str,
        data: Any = None,  # noqa: ARG002 it tells paths and lines of code
        client_id: str | None = None,
    ) -> None:
        """An error without wslink's traces."""
        if client_id is not None:
            error = {"code": code, "message": message}
            await self._send(client_id, msgpack.packb({"wslink": "1.0", "id": rpcid, "error": error}))

    async def _send(self, client_id: str, packed: bytes) -> None:
        """Send a message to a client that may be going."""
        end, lock = self.connections.get(client_id), self._sending.get(client_id)
        if end is not None and lock is not None:
            async with lock:
                with suppress(ConnectionError):
                    for chunk in generate_chunks(packed, MAX_MSG_SIZE):
                        await end.send_bytes(chunk)
        self.network_monitor.network_call_completed()
