"""Access control, and validation of messages and uploads."""

import asyncio
import io
import json
import math
import random

import pytest

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

from pvphong.studio.web import access
from pvphong.studio.web.access import (
    Access,
    Malformed,
    is_loopback,
    plain,
    refuse_lamp_files,
    upload,
    view_event,
    view_size,
)

web = pytest.importorskip("aiohttp.web")


@pytest.mark.parametrize(
    ("host", "is_own"),
    [
        *((host, True) for host in ("127.0.0.1", "127.9.9.9", "::1", "localhost")),
        *((host, False) for host in ("0.0.0.0", "::", "192.168.1.4", "localhost.evil.example", "")),
    ],
)
def test_only_this_machine_is_this_machine(host, is_own):
    assert is_loopback(host) is is_own
    assert bool(Access(host).token) is not is_own


@pytest.mark.parametrize(
    ("host", "origin", "is_admitted"),
    [
        ("127.0.0.1:80", None, True),
        ("localhost:80", "http://localhost:80", True),
        ("[::1]:80", "http://[::1]:80", True),
        ("127.0.0.1:80", "http://127.0.0.1:81", False),
        ("127.0.0.1:80", "http://localhost:80", False),
        ("127.0.0.1:80", "http://evil.example", False),
        ("127.0.0.1:80", "null", False),
        ("127.0.0.1:80", "http://[", False),
        ("evil.example:80", "http://evil.example:80", False),  # DNS rebinding
        ("", None, False),
    ],
)
def test_on_this_machine_pages_of_other_origins_are_not_let_in(host, origin, is_admitted):
    assert Access("127.0.0.1").admits(host, origin, "/") is is_admitted


def test_from_elsewhere_nothing_is_answered_without_the_token():
    guarded = Access("0.0.0.0")
    token = guarded.token
    assert guarded.root == f"/{token}/"
    assert len(token) >= 32
    assert guarded.admits("box:80", "http://box:80", f"/{token}/")
    assert guarded.admits("box:80", None, f"/{token}/take/rig")
    assert not guarded.admits("box:80", "http://evil.example", f"/{token}/")
    for wrong in ("", token[:-1], token + "x", "é", token.swapcase()):
        assert not guarded.admits("box:80", "http://box:80", f"/{wrong}/")
        assert not guarded.admits("box:80", "http://box:80", f"/{wrong}/{token}/")
    for path in ("", "/", f"/{token}", f"{token}/", f"//{token}/"):
        assert not guarded.admits("box:80", "http://box:80", path)
    assert Access("0.0.0.0").token != token


def in_a_server(guarded, run, *, add=lambda _app: None):
    """Run a guarded server, and call `run` with a client session and the address."""
    from aiohttp import ClientSession

    async def hello(_request):
        return web.Response(text="hello")

    async def main():
        app = web.Application()
        guarded.guard(app)
        app.router.add_get("/", hello)
        add(app)
        runner = web.AppRunner(app, lingering_time=0.2)
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        try:
            async with ClientSession() as session:
                return await run(session, f"http://127.0.0.1:{runner.addresses[0][1]}/")
        finally:
            await runner.cleanup()

    return asyncio.run(main())


def test_all_is_below_the_token_and_nothing_beside_it(tmp_path):
    guarded = Access("0.0.0.0")
    (tmp_path / "page.js").write_text("script")
    wrong = Access("0.0.0.0").token
    below = {"": "hello", "rigs/mine": "mine", "files/page.js": "script"}

    async def named(request):
        return web.Response(text=request.match_info["name"])

    def routes(app):
        app.router.add_get("/rigs/{name}", named)
        app.router.add_static("/files", tmp_path)

    async def run(session, address):
        async def ask(path, **more):
            async with session.get(address + path, **more) as answer:
                return answer.status, await answer.text(), dict(answer.headers)

        for path, text in below.items():
            status, found, heading = await ask(f"{guarded.token}/{path}")
            assert (status, found) == (200, text)
            assert heading["Referrer-Policy"] == "no-referrer"
            assert "Set-Cookie" not in heading
        for path in (*below, *(f"{wrong}/{path}" for path in below), guarded.token, "nowhere", "index.html"):
            assert (await ask(path))[:2] == (403, "")
        for how in ({"params": {"token": guarded.token}}, {"cookies": {"pvphong-studio": guarded.token}}):
            assert (await ask("", **how))[0] == 403
        assert (await ask(f"{guarded.token}/nowhere"))[0] == 404

    in_a_server(guarded, run, add=routes)


def test_uploads_are_limited_by_kind_and_size_and_written_under_our_own_name(monkeypatch):
    monkeypatch.setattr(access, "LARGEST_FILE", 2**20)
    guarded, taken, said = Access("127.0.0.1"), [], []

    async def take(name, path, _query):
        taken.append((name, path.name, path.read_bytes()))
        if name == "bad.ply":
            raise ValueError(f"mesh must be whole; got {path}.")

    async def endless():
        for _ in range(64):
            yield b"x" * 2**16

    async def run(session, address):
        found = []
        for query, body in [
            ("?name=part.ply", b"abc"),
            ("?name=..%2F..%2Fetc%2Fpart.PLY", b"abc"),
            ("?name=C:%5Cpart.ply", b"abc"),
            ("?name=part.exe", b"abc"),
            ("?name=.ply", b"abc"),
            ("", b"abc"),
            ("?name=part.ply", b""),
            ("?name=bad.ply", b"abc"),
            ("?name=part.ply", io.BytesIO(b"x" * (2**20 + 1))),
            ("?name=part.ply", endless()),
        ]:
            try:
                async with session.post(f"{address}up{query}", data=body) as answer:
                    found.append((answer.status, await answer.text()))
            except OSError:  # refused while sending
                found.append((400, "file must be at most 1 MiB"))
        return found

    found = in_a_server(guarded, run, add=lambda app: app.router.add_post("/up", upload((".ply",), take, said.append)))
    assert [status for status, _ in found] == [204, 204, 204, 400, 400, 400, 400, 400, 400, 400]
    assert [name for name, _, _ in taken] == ["part.ply", "part.PLY", "part.ply", "bad.ply"]
    assert {written for _, written, _ in taken} == {"upload.ply"}
    assert found[7][1] == "mesh must be whole; got bad.ply."  # without the temporary folder
    assert all(reason.startswith("file must be") for _, reason in (*found[3:7], *found[8:]))
    assert [bool(reason) for reason in said] == [status == 400 for status, _ in found]


PRESS = {"type": "LeftButtonPress", "x": 10, "y": 20, "w": 300, "h": 200, "shiftKey": 1}


def test_events_of_the_view_come_with_every_key_that_vtk_reads():
    assert view_event(PRESS) == PRESS | {"altKey": 0, "ctrlKey": 0, "metaKey": 0}
    assert view_event({"type": "StartInteractionEvent", "more": 1}) == {"type": "StartInteractionEvent"}
    key = view_event({"type": "KeyDown", "key": "h", "controlKey": False})
    assert key["key"] == "h"
    assert key["controlKey"] is False
    assert view_event({"type": "MouseWheel", "x": 1, "y": 2, "spinY": -1.5})["spinY"] == -1.5
    assert view_size({"w": 1e5, "h": 20, "p": 2}) == {"w": 2048.0, "h": 20, "p": 2}
    assert plain(["light.1.on", True, [0, 1.5, None]]) == ["light.1.on", True, [0, 1.5, None]]


NESTED = []
for _ in range(100):
    NESTED = [NESTED]
MALFORMED = {
    view_event: [
        *(None, [], {}, {"type": None}, {"type": "Explode"}, {"type": ["MouseMove"]}),
        *(PRESS | {"x": x} for x in (math.nan, "1", True, 1e9, 10**400)),
        *({"type": "KeyDown", "key": key} for key in (5, "x" * 100)),
        {"type": "MouseWheel", "spinY": math.inf},
    ],
    view_size: [None, {"w": -1, "h": 5}, {"w": 1, "h": math.nan}, {"w": 1, "h": 1, "p": 0}, {"w": "a"}],
    plain: [[bad] for bad in (NESTED, {"a": 1}, math.inf, b"bytes", "x" * 2**17, [0] * 2**17, object())],
}


@pytest.mark.parametrize("take", MALFORMED)
def test_what_is_malformed_is_refused(take):
    for given in MALFORMED[take]:
        with pytest.raises(Malformed):
            take(given)


def test_no_garbage_gets_through_as_anything_but_an_event():
    """Accepted events can be written as JSON for VTK, with finite numbers."""
    draw = random.Random(32)
    values = [None, True, -1, 10**400, 1e308, math.nan, "x", "", [], {}, [1, 2], b"", {"x": 1}]
    kinds = ["MouseMove", "KeyUp", "MouseWheel", "Pinch", "Pan", "Tap", "EndInteractionEvent", "?"]
    names = [*"xywh", "shiftKey", "spinY", "key", "keyCode", "factor", "rotation", "translation", "positions"]
    passed = 0
    for _ in range(3000):
        given = {name: draw.choice(values) for name in draw.sample(names, draw.randrange(6))}
        try:
            event = view_event(given | {"type": draw.choice(kinds)})
        except Malformed:
            continue
        passed += 1
        json.dumps(event, allow_nan=False)
    assert passed > 100


def test_an_uploaded_rig_opens_no_file_of_the_server(tmp_path):
    rig = tmp_path / "rig.json"
    for lamp in ({"photometry": "/etc/passwd"}, {"fields": {"photometry": "C:\\secret\\lamp.ies"}}):
        rig.write_text(json.dumps({"lights": [{"intensity": 1.0}, lamp]}))
        with pytest.raises(ValueError, match=r"^photometry must be the numbers of a lamp in an uploaded rig"):
            refuse_lamp_files(rig)
    for text in ('{"lights": [{"photometry": {"candela": [[1.0]]}}]}', "[" * 100_000, "{", ""):
        rig.write_text(text)
        refuse_lamp_files(rig)
