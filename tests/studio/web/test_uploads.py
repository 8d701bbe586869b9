"""Uploads of measured lamps, the limits of every upload, and files that cannot be dropped onto the page."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from photometric_files import eulumdat, ies
from studios import in_a_studio

pytest.importorskip("trame_pyvista", reason="the studio needs the extra trame")

import pvphong as ph
from pvphong.studio.web.access import Access
from pvphong.studio.web.messages import in_page_words
from pvphong.studio.web.uploads import DROPPED, refuse_file

V = np.arange(0.0, 91.0, 15.0)
ALONG = 1000.0 * np.cos(np.radians(V))


@pytest.fixture
def plotter(new_plotter, tmp_path, monkeypatch):
    """A plotter with a lamp and a ball that is read from the working directory."""
    monkeypatch.chdir(tmp_path)
    pv.Sphere(theta_resolution=12, phi_resolution=12).save("ball.vtp")
    plotter = new_plotter((64, 48))
    plotter.phong.add_light(ph.DirectionalLight((0, 0.3, -1), name="sun"))
    plotter.phong.add_mesh(ph.read("ball.vtp"), "gold")
    plotter.show(auto_close=False)
    return plotter


def lamp_files(folder):
    """Write an IES file and a EULUMDAT file of one lamp; return their paths."""
    return (
        ies(folder / "street.ies", V, [0.0], [ALONG]),
        eulumdat(folder / "hall.ldt", 1, [0.0], V, [ALONG]),
    )


@pytest.mark.parametrize("which", [0, 1], ids=["ies", "ldt"])
def test_a_lamp_is_placed_and_aimed_like_a_new_spot_as_one_step(plotter, tmp_path, which):
    path = lamp_files(tmp_path)[which]

    async def act(studio):
        document = studio.document
        document.add("spot")
        spot = plotter.phong.lights[-1]
        assert document.undo()
        said = await studio._uploads.take_lamp(path.name, path, {})
        _, lamp = plotter.phong.lights
        assert isinstance(lamp, ph.PhotometricLight)
        assert lamp.name == path.stem
        np.testing.assert_allclose(lamp.position, spot.position)
        np.testing.assert_allclose(lamp.direction, spot.direction)
        assert lamp.measured == ph.PhotometricLight(path).measured
        assert said.startswith(f"{path.name} is added at {lamp.intensity:.3g} times")
        row = document.shown()["lights"][-1]
        assert (row["selected"], row["called"]) == (True, path.stem)
        assert document.gizmos.all[-1].handles.keys() == {"target", "position"}
        shining = np.array(plotter.phong._subplot.lit.meshes[0].drawn["phong"], int)
        assert document.undo()
        assert [light.name for light in plotter.phong.lights] == ["sun"]
        plotter.render()
        assert (shining - plotter.phong._subplot.lit.meshes[0].drawn["phong"]).max() > 20
        assert document.redo()
        await studio._uploads.take_lamp(path.name, path, {})
        assert plotter.phong.lights[-1].name == f"{path.stem} 2"

    in_a_studio(plotter, act, file="ball.vtp")


def test_rig_and_script_carry_a_lamp(plotter, tmp_path):
    street, _ = lamp_files(tmp_path)

    async def act(studio):
        await studio._uploads.take_lamp("street.ies", street, {})
        street.unlink()
        return studio.downloads

    downloads = in_a_studio(plotter, act, file="ball.vtp")
    rig = downloads.write("rig", tmp_path)
    assert ph.Scene.load(rig).lights == plotter.phong.lights
    assert "street.ies" not in rig.read_text()
    found = {}
    exec(compile(downloads.script(), "script", "exec"), found)
    np.testing.assert_array_equal(found["lit"]["phong"], downloads.lit["phong"])


def test_a_lamp_that_does_not_shine_ahead_does_not_glare(plotter, tmp_path):
    up = ies(tmp_path / "up.ies", [90.0, 120.0, 180.0], [0.0], [[0.0, 5e4, 9e4]])

    async def act(studio):
        await studio._uploads.take_lamp("up.ies", up, {})
        lamp = plotter.phong.lights[-1]
        distance = np.linalg.norm(lamp.position)
        assert 0.1 < lamp.intensity * 9e4 / distance**2 < 1.0

    in_a_studio(plotter, act, file="ball.vtp")


@pytest.mark.parametrize("tilt", ["/etc/passwd", "../../../../../../etc/passwd", "secret.tlt"])
def test_no_other_file_is_opened_for_a_lamp(plotter, tmp_path, monkeypatch, tilt):
    (tmp_path / "secret.tlt").write_text("1\n2\n0 90\n1 0.5\n")
    path = ies(tmp_path / "upload.ies", V, [0.0], [ALONG], tilt=f"TILT={tilt}")
    opened = []
    real = io.open

    def watched(file, *args, **options):
        opened.append(str(file))
        return real(file, *args, **options)

    monkeypatch.setattr(io, "open", watched)  # what `Path` calls
    Path(path).read_bytes()
    assert opened == [str(path)]

    async def act(studio):
        before = studio.document.state
        opened.clear()
        with pytest.raises(ValueError, match="its tilt is in another file") as refusal:
            await studio._uploads.take_lamp("street.ies", path, {})
        assert [each for each in opened if each.endswith((".ies", ".tlt", "passwd"))] == [str(path)]
        assert (studio.document.state, studio.document.history.can_undo) == (before, False)
        return str(refusal.value)

    said = in_a_studio(plotter, act, file="ball.vtp")
    assert in_page_words(said).startswith(
        "Photometry must be an IES (LM-63) or EULUMDAT file, not street.ies. Its tilt"
    )
    assert str(tmp_path) not in said


DAMAGES = {
    "cut short": lambda text: text[: len(text) // 2],
    "empty": lambda _: "\n",
    "words": lambda text: text.replace("1000", "bright"),
    "bytes": lambda _: "\0" * 50,
    "another file": lambda _: "solid part\nendsolid part\n",
}


def test_a_damaged_lamp_is_refused_in_one_line_and_changes_nothing(plotter, tmp_path):
    async def act(studio):
        before = studio.document.state
        for path in lamp_files(tmp_path):
            for damage in DAMAGES.values():
                damaged = tmp_path / f"upload{path.suffix}"
                damaged.write_text(damage(path.read_text()))
                with pytest.raises(ValueError, match=rf"^photometry must be .*; got {path.name}\.") as refusal:
                    await studio._uploads.take_lamp(path.name, damaged, {})
                assert "\n" not in str(refusal.value)
                assert str(tmp_path) not in str(refusal.value)
        assert (studio.document.state, studio.document.history.can_undo) == (before, False)

    in_a_studio(plotter, act, file="ball.vtp")


def test_the_page_cannot_name_a_file_of_the_server_for_a_lamp(plotter, tmp_path):
    street, _ = lamp_files(tmp_path)

    async def act(studio):
        await studio._uploads.take_lamp("street.ies", street, {})
        before, number = studio.document.state, studio.document.shown()["lights"][-1]["number"]
        for given in (str(street), "/etc/passwd"):
            with pytest.raises(ValueError, match="photometry must be a number"):
                studio.document.edit(f"light.{number}.photometry", given)
        assert studio.document.state == before

    in_a_studio(plotter, act, file="ball.vtp")


def test_every_upload_needs_the_token_and_has_a_limit(plotter, tmp_path):
    """Lamps are limited to 16 MiB, meshes to 256 MiB."""
    web = pytest.importorskip("aiohttp.web")
    from aiohttp import ClientSession

    street, _ = lamp_files(tmp_path)

    async def act(studio):
        said, access, app = [], Access("0.0.0.0"), web.Application()
        access.guard(app)
        studio._uploads.add_routes(app.router, said.append)
        runner = web.AppRunner(app, lingering_time=0.2)
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        address = f"http://127.0.0.1:{runner.addresses[0][1]}"
        ours, found = f"{address}/{access.token}", []
        try:
            async with ClientSession() as session:
                for place, name, body in (
                    (address, "street.ies", street.read_bytes()),
                    (f"{address}/{Access('0.0.0.0').token}", "street.ies", street.read_bytes()),
                    (ours, "street.exe", street.read_bytes()),
                    (ours, "street.ies", b""),
                    (ours, "street.ies", street.read_bytes()),
                    (ours, "street.ies", io.BytesIO(bytes(60 * 2**20))),
                ):
                    try:
                        async with session.post(f"{place}/bring/lamp?name={name}", data=body) as answer:
                            found.append(answer.status)
                    except OSError:  # refused while sending
                        found.append(400)
        finally:
            await runner.cleanup()
        return found, said

    found, said = in_a_studio(plotter, act, file="ball.vtp")
    assert found == [403, 403, 400, 400, 204, 400]
    assert said[0] == "file must be of type .ies, .ldt; got street.exe."
    assert "an empty file" in said[1]
    assert said[2].startswith("street.ies is added")
    assert said[3] == "file must be at most 16 MiB; got street.ies, 60 MiB."
    assert [light.name for light in plotter.phong.lights] == ["sun", "street"]


@pytest.mark.parametrize("name", ["part.exe", "folder", "", "/home/me/part.zip", "x" * 500])
def test_a_file_that_cannot_be_dropped_is_refused_in_one_line_with_all_suffixes(name):
    with pytest.raises(ValueError, match=r"^file must be a mesh \(") as refusal:
        refuse_file(name)
    assert all(suffix in str(refusal.value) for suffix in DROPPED)
    assert "/home" not in str(refusal.value)
    assert len(str(refusal.value)) < 300
    json.dumps(DROPPED)


def test_what_is_no_name_of_a_dropped_file_is_refused():
    with pytest.raises(ValueError, match="file must be a string"):
        refuse_file(5)
