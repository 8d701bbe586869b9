"""Access to the studio: access control for HTTP and WebSocket, validation of messages, and uploads.

A server on a loopback address admits all local requests, except from pages of another origin. On any other address, all
paths begin with a folder whose name is a secret token, and other requests are refused. A cookie cannot replace the
token, because browsers send no cookies from a page that is framed in a page of another host, such as a notebook.

Only messages that trame's page sends are accepted. Each message is validated before it is used, and a malformed message
is answered with an error. Otherwise VTK's adapter of remote events, for example, would crash on a missing key.
"""

from __future__ import annotations

import asyncio
import hmac
import ipaddress
import json
import secrets
import socket
import tempfile
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from pathlib import Path, PurePath
from typing import Any
from urllib.parse import urlsplit

import msgpack
from aiohttp import web
from wslink.backends.aiohttp import AioHttpWsHandler
from wslink.chunking import generate_chunks
from wslink.protocol import MAX_MSG_SIZE

from pvphong.base import check
from pvphong.studio.web.sharing import SharedSize

_LARGEST_MESSAGE = 2**20
"""Largest message, in bytes; files are sent by HTTP."""
_FRAME = "publish:trame.rca.topic.stream:"
"""Prefix of the ids of messages that contain a picture of the view."""
_MOST_PENDING = 4
"""Largest number of incomplete messages of one client."""
LARGEST_FILE = 2**28
"""Largest uploaded file, in bytes: 256 MiB."""
_PIECE = 2**16
_MOST_PIXELS = 4096  # width or height of a view
_MOST_NESTED = 8
_LARGEST = 1e300  # number
_LONGEST = 2**16  # characters of a text, entries of a list

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


# --- access control


def is_loopback(host: str) -> bool:
    """Return True if a host name or address is loopback, so that only this machine can reach it."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


class Access:
    """Access control of the studio's server.

    Parameters
    ----------
    host : str
        The address that the server listens on.
    """

    def __init__(self, host: str) -> None:
        self._host, self._is_local = host, is_loopback(host)
        self.token = "" if self._is_local else secrets.token_urlsafe(24)
        """Secret first folder of all paths; "" on a loopback address."""

    @property
    def root(self) -> str:
        """Beginning of all paths on the server: "/" or, with a token, "/TOKEN/"."""
        return f"/{self.token}/" if self.token else "/"

    def address_at(self, port: int) -> str:
        """Return the address of the page, with the server at `port`."""
        host = self._host
        if host in ("0.0.0.0", "::"):
            host = socket.gethostname()
            try:
                socket.getaddrinfo(host, None)
            except OSError:
                host = "127.0.0.1"
        return f"http://{f'[{host}]' if ':' in host else host}:{port}{self.root}"

    def guard(self, app: web.Application) -> None:
        """Check every request to the web application `app`, and move its routes below the secret folder."""
        app.middlewares.append(self._admit)
        if self.token:
            app.on_startup.append(self._move)  # all routes are defined then

    async def _move(self, app: web.Application) -> None:
        for resource in app.router.resources():
            app.router.unindex_resource(resource)  # aiohttp indexes resources by path
            resource.add_prefix(f"/{self.token}")
            app.router.index_resource(resource)

    @web.middleware
    async def _admit(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        if not self.admits(request.host, request.headers.get("Origin"), request.path):
            return web.Response(status=403)
        try:
            response = await handler(request)
        except web.HTTPException as answer:  # a redirection or "not found"
            self._finish(answer)
            raise
        self._finish(response)
        return response

    @staticmethod
    def _finish(response: web.StreamResponse) -> None:
        """Set headers that keep the browser from sending the token to other sites."""
        if not response.prepared:
            response.headers["Referrer-Policy"] = "no-referrer"
            response.headers["X-Content-Type-Options"] = "nosniff"

    def admits(self, host: str, origin: str | None, path: str) -> bool:
        """Return True if a request is admitted.

        Parameters
        ----------
        host : str
            The `Host` header. If the server listens on a loopback address, the header must name one too. This prevents
            DNS rebinding by other sites.
        origin : str or None
            Origin of the page that sends the request, if any.
        path : str
            The requested path.
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


# --- uploads


async def receive(
    request: web.Request, suffixes: tuple[str, ...], folder: Path, largest: int | None = None
) -> tuple[str, Path]:
    """Write an uploaded file into a folder, under a fixed name.

    Parameters
    ----------
    request : aiohttp.web.Request
        The upload. Its body is the file. Of the file's name, `name` in the query, only the suffix is used.
    suffixes : tuple of str
        Allowed suffixes.
    folder : Path
        A folder for this file only.
    largest : int, optional
        Largest allowed size in bytes; by default `LARGEST_FILE`.

    Returns
    -------
    name : str
        The file's name, without folders.
    path : Path
        Path of the written file.

    Raises
    ------
    ValueError
        If the suffix is not allowed, or the file is empty or larger than `largest`. Reading stops at `largest`.
    """
    name = request.query.get("name", "").replace("\\", "/").rpartition("/")[2][:200]
    suffix = Path(name).suffix.lower()
    if suffix not in suffixes:
        check.refuse("file", name or "a file without a name", f"of type {', '.join(suffixes)}")
    largest = LARGEST_FILE if largest is None else largest
    allowed = f"at most {largest >> 20} MiB"
    if (request.content_length or 0) > largest:
        check.refuse("file", f"{name}, {(request.content_length or 0) >> 20} MiB", allowed)
    path, size = folder / f"upload{suffix}", 0
    with path.open("wb") as file:
        async for piece in request.content.iter_chunked(_PIECE):
            size += len(piece)
            if size > largest:
                check.refuse("file", f"{name}, a larger file", allowed)
            file.write(piece)
    if not size:
        check.refuse("file", f"{name}, an empty file", "a file with content")
    return name, path


def upload(
    suffixes: tuple[str, ...],
    take: Callable[[str, Path, Mapping[str, str]], Awaitable[str | None]],
    done: Callable[[str], None],
    *,
    largest: int | None = None,
) -> Handler:
    """Return a handler of upload requests. The handler passes each file to `take` and then deletes the file.

    Parameters
    ----------
    suffixes : tuple of str
        Allowed suffixes.
    take : callable
        Called with the file's name, the path of the upload, and the request's query. It returns a message, if any, and
        raises ValueError to reject the file.
    done : callable
        Called with the error message if the file was rejected, else with the message of `take` or "".
    largest : int, optional
        Largest size of a file in bytes; by default `LARGEST_FILE`.
    """

    async def handle(request: web.Request) -> web.StreamResponse:
        reason = name = said = ""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder)
            try:
                name, path = await receive(request, suffixes, path, largest)
                said = await take(name, path, request.query) or ""
            except ValueError as error:
                reason = str(error).replace(str(path), name)
        done(reason or said)
        answer = web.Response(status=400 if reason else 204, text=reason or None)
        if reason:
            answer.force_close()  # do not read the rest of a file that is too large
        return answer

    return handle


async def no_launcher(_request: web.Request) -> web.StreamResponse:
    """Answer the request that trame's page sends first to a launcher of sessions: there is no launcher.

    The page then connects to the server that it comes from. An error would have the same effect, but browsers log it.
    """
    return web.Response(status=204)


# --- messages


class Malformed(ValueError):
    """Raised for a message that the studio's own page would not send."""


_MOUSE = {f"{button}Button{what}" for button in ("Left", "Middle", "Right") for what in ("Press", "Release")}
_WHEEL = {"StartMouseWheel", "MouseWheel", "EndMouseWheel"}
_KEYS = {"KeyDown", "KeyPress", "KeyUp"}
_TOUCH = {f"{when}{what}" for what in ("Pinch", "Rotate", "Pan") for when in ("Start", "", "End")}
_TOUCH |= {"Tap", "LongTap"}
_MODIFIERS = ("shiftKey", "altKey", "ctrlKey", "metaKey")
_IDLE = {"StartInteractionEvent", "EndInteractionEvent"}


def view_event(given: Any) -> dict[str, Any]:
    """Return the event `given` of mouse, wheel, keyboard or touch, after validation.

    The result has all keys that VTK's adapter reads, and its values are in range.

    Raises
    ------
    Malformed
        If the event is not valid.
    """
    if not isinstance(given, dict) or not isinstance(given.get("type"), str):
        raise Malformed("an event needs a type")
    kind = given["type"]
    if kind in _IDLE:
        return {"type": kind}
    if kind not in {"MouseMove", *_MOUSE, *_WHEEL, *_KEYS, *_TOUCH}:
        raise Malformed("unknown event")
    event: dict[str, Any] = {"type": kind} | {name: int(bool(given.get(name))) for name in _MODIFIERS}
    event |= {name: _number(given.get(name, 0.0), -_MOST_PIXELS, _MOST_PIXELS) for name in "xywh"}
    if kind in _WHEEL:
        event["spinY"] = _number(given.get("spinY", 0.0), -100.0, 100.0)
    if kind in _KEYS:
        key = given.get("key", "")
        if not isinstance(key, str) or len(key) > 20 or not key.isprintable():
            raise Malformed("unknown key")
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
    """Return the size of a view in a browser, after validation. It is limited to the largest window."""
    if not isinstance(given, dict):
        raise Malformed("a size needs a width and a height")
    width, height = (_number(given.get(name, 0.0), 0.0, 1e6) for name in ("w", "h"))
    ratio = _number(given.get("p", 1.0), 0.1, 10.0)
    most = _MOST_PIXELS / ratio
    return {"w": min(width, most), "h": min(height, most), "p": ratio}


def _number(given: Any, least: float, most: float) -> float:
    if type(given) not in (int, float) or not least <= given <= most:  # also false for NaN
        raise Malformed("not a number, or out of range")
    return given


def _list(given: Any, count: int) -> list[Any]:
    if not isinstance(given, list) or len(given) != count:
        raise Malformed(f"a list needs {count} entries")
    return given


def plain(given: Any, depth: int = 0) -> Any:
    """Return `given` if it is a text, a number, a flag, None, or a list of these, of limited size.

    Otherwise raise `Malformed`. `depth` is the number of lists around the value.
    """
    if isinstance(given, list) and depth < _MOST_NESTED and len(given) <= _LONGEST:
        return [plain(each, depth + 1) for each in given]
    if given is None or (isinstance(given, int | float) and -_LARGEST <= given <= _LARGEST):
        return given
    if isinstance(given, str) and len(given) <= _LONGEST:
        return given
    raise Malformed("a value must be a text, a finite number, a flag or a list")


class Messages(AioHttpWsHandler):
    """The server's end of the WebSocket: handles the messages of the studio's page, and rejects all others.

    Parameters
    ----------
    protocol : wslink.websocket.ServerProtocol
        trame's protocol.
    server : wslink's web server
        trame's web server.
    triggers : mapping
        Name → function, for each trigger of the page.
    closed : callable
        Called when a client has disconnected, with True if the client held the left mouse button down in the view.
    scaled : callable
        Called with the number of device pixels per CSS pixel, before the view gets another size.
    """

    def __init__(
        self,
        protocol: Any,
        server: Any,
        triggers: Mapping[str, Callable[..., Any]],
        closed: Callable[[bool], None],
        scaled: Callable[[float], None],
    ) -> None:
        super().__init__(protocol, server)
        self._triggers, self._closed, self._scaled = triggers, closed, scaled
        self._shared = SharedSize()
        self._area = self._held_by = ""
        self._sending: dict[str, asyncio.Lock] = {}
        self._frames: dict[str, bytes] = {}

    async def onMessage(self, is_binary: bool, msg: Any, client_id: str) -> None:
        """Handle a frame of the WebSocket, which is a whole message or a part of one."""
        pieces = self.unchunkers[client_id]
        try:
            if not is_binary:
                raise Malformed("frames must be binary")
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
        """Return a message after its arguments are validated.

        Raise `Malformed` if the studio's page does not send such a message.
        """
        if not isinstance(message, dict) or not isinstance(message.get("id"), str) or len(message["id"]) > 200:
            raise Malformed("a message needs an id")
        method, args = message.get("method"), message.get("args", [])
        if not isinstance(args, list) or message.get("kwargs"):
            raise Malformed("a message needs a list of arguments")
        if message["id"].startswith("system:"):
            if method == "wslink.hello" and len(args) == 1 and isinstance(args[0], dict):
                return {"id": message["id"], "method": method, "args": args}
            raise Malformed("unknown method")
        if not self.isClientAuthenticated(client_id):
            raise Malformed("the first message must be a greeting")
        if method == "trame.trigger":
            name, given, named = (*args, {})[:3]
            if name not in self._triggers or named or not isinstance(given, list):
                raise Malformed("unknown trigger")
            args = [name, plain(given), {}]
        elif method == "trame.rca.event":
            args = [*map(str, _list(args, 3)[:2]), self._shared.converted(view_event(args[2]), client_id)]
            if args[2]["type"].startswith("LeftButton"):
                self._held_by = client_id if args[2]["type"].endswith("Press") else ""
        elif method == "trame.rca.size":
            args = [*map(str, _list(args, 3)[:2]), view_size(args[2])]
            self._shared.put(client_id, args[2])
            self._area, args[2] = args[0], dict(self._shared.size or {})
            self._scaled(args[2]["p"])
        elif method == "trame.lifecycle.update":
            if args not in (["client_connected"], ["client_mounted"], ["client_exited"], ["client_unmounted"]):
                raise Malformed("unknown event")
        elif method == "trame.rca.video.codecs":
            args = [str(_list(args, 1)[0])]
        elif method != "trame.state.get":
            raise Malformed("unknown method")
        return {"id": message["id"], "method": method, "args": args}

    async def handleSystemMessage(self, rpcid: str, methodName: str, args: list[Any], client_id: str) -> bool:
        """Handle a greeting. Then limit the message size again, because wslink sets the limit to 4 GiB."""
        is_system: bool = await super().handleSystemMessage(rpcid, methodName, args, client_id)
        self.unchunkers[client_id].set_max_message_size(_LARGEST_MESSAGE)
        return is_system

    async def onConnect(self, request: web.Request, client_id: str) -> None:
        """Handle a client's connection."""
        self._sending[client_id] = asyncio.Lock()
        await super().onConnect(request, client_id)

    async def onClose(self, client_id: str) -> None:
        """Handle a client's disconnection."""
        await super().onClose(client_id)
        for known in (self._sending, self._frames):
            known.pop(client_id, None)
        if self._shared.remove(client_id) and (size := self._shared.size) is not None:
            self._scaled(size["p"])
            areas, resize = self.functionMap["trame.rca.size"]
            resize(areas, self._area, "access", dict(size))
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
        skip_last_active_client: bool = False,  # noqa: ARG002 wslink's signature
    ) -> None:
        """Send a message to one client. wslink's own method would make all clients wait for the slowest client.

        If several pictures are pending for a client, only the last one is sent.
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
        data: Any = None,  # noqa: ARG002 it contains paths and lines of code
        client_id: str | None = None,
    ) -> None:
        """Send an error without wslink's traceback."""
        if client_id is not None:
            error = {"code": code, "message": message}
            await self._send(client_id, msgpack.packb({"wslink": "1.0", "id": rpcid, "error": error}))

    async def _send(self, client_id: str, packed: bytes) -> None:
        """Send a message to a client. If the client is disconnecting, do nothing."""
        end, lock = self.connections.get(client_id), self._sending.get(client_id)
        if end is not None and lock is not None:
            async with lock:
                with suppress(ConnectionError):
                    for chunk in generate_chunks(packed, MAX_MSG_SIZE):
                        await end.send_bytes(chunk)
        self.network_monitor.network_call_completed()


def refuse_lamp_files(rig: Path) -> None:
    """Raise ValueError if a lamp of an uploaded rig names a file, because the server would open this file.

    A file that is not a rig passes; `Scene.load` reports it.
    """
    try:
        left = [json.loads(rig.read_bytes())]
    except (OSError, ValueError, RecursionError):
        return
    while left:
        value = left.pop()
        if isinstance(value, dict):
            if isinstance(given := value.get("photometry"), str):
                remedy = "A rig that is saved by pvphong contains the lamp's numbers."
                allowed = "the numbers of a lamp in an uploaded rig, not a file"
                check.refuse("photometry", PurePath(given).name, allowed, remedy)
            left.extend(value.values())
        elif isinstance(value, list):
            left.extend(value)
