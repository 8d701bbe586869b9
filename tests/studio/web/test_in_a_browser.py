"""The studio in a real Chromium: panels, gizmos, one undo history, two browsers, and malformed messages."""

import asyncio
import json
import re
import subprocess
import sys
import time
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import numpy as np
import pytest
import pyvista as pv
from browsers import needs_a_browser
from pages import Page, Served, bring, switch

import pvphong as ph
from pvphong.optics.lights import LIGHT_TYPES

pytestmark = needs_a_browser


def test_all_kinds_of_light_are_added_by_a_click_and_undone(page):
    for kind in LIGHT_TYPES:
        page.settled(lambda kind=kind: page.all(f"add-{kind}")[0].rect)  # the row of the new light moves the buttons
        page.click(f"add-{kind}")
        page.until(lambda kind=kind: page.light(kind)["selected"])
    assert len(page.all("light-row")) == 3 + len(LIGHT_TYPES)
    for _ in LIGHT_TYPES:
        page.click("undo")
        time.sleep(0.1)
    page.until(lambda: len(page.all("light-row")) == 3)
    page.click("redo")
    page.until(lambda: page.light("directional"))


def test_a_gizmo_is_dragged_in_the_view_and_undone_in_the_panel(page):
    page.click("add-spot")
    before = page.until(lambda: page.light("spot")["fields"])
    page.until(lambda: len(page.state("lights")) == 4)
    time.sleep(0.5)  # until the gizmo is drawn
    page.drag((70, -50))  # the light's target is the centre of the mesh
    page.until(lambda: page.light("spot")["fields"] != before)
    aimed = page.settled(lambda: page.light("spot")["fields"])
    changed = [entry["name"] for entry, old in zip(aimed, before, strict=True) if entry != old]
    assert changed == ["direction"]
    page.click("undo")
    page.until(lambda: page.light("spot")["fields"] == before)
    page.click("redo")
    page.until(lambda: page.light("spot")["fields"] == aimed)


def test_a_connection_that_is_lost_in_mid_drag_puts_the_light_back(page):
    page.click("add-spot")
    before = page.until(lambda: page.light("spot")["fields"])
    time.sleep(0.5)  # until the gizmo is drawn
    held = page.drag((60, -40), release=False)
    page.until(lambda: page.light("spot")["fields"] != before)
    page.driver.refresh()
    page.until(lambda: page.light("spot")["fields"] == before)
    page.until(lambda: "is back at its old position" in page.state("notice"))
    held.clear_actions()


def test_numbers_names_and_colours_are_typed_and_what_is_refused_is_said(page):
    page.type("intensity", "0.25", page.row("key"))
    page.until(lambda: page.light("key")["intensity"]["value"] == 0.25)
    page.type("colour", "#00ff00", page.row("key"))
    page.until(lambda: page.light("key")["diffuse"]["value"] == [0.0, 1.0, 0.0])
    page.until(lambda: page.middle()[1] > page.middle()[0] + 20)
    page.type("light-name", "sun", page.row("key"))
    page.until(lambda: page.light("sun"))
    page.type("intensity", "-3", page.row("sun"))
    page.until(lambda: "Brightness: -3 is out of range. Enter 0 or more." in page.all("notice")[0].text)
    assert page.light("sun")["intensity"]["value"] == 0.25
    page.until(lambda: page.typed("intensity", page.row("sun")) == "0.25")
    for _ in range(3):
        page.click("undo")
    page.until(lambda: page.light("key") and not page.state("can_undo"))


NO_NUMBERS = {"1,000": ": “1,000” is ambiguous", "abc": ": “abc” is not a number."}
"""Ambiguous or invalid numbers, and their error messages."""


def test_numbers_are_taken_as_they_are_typed_or_refused(page):
    from selenium.webdriver.common.keys import Keys

    key = page.row("key")
    for typed, said in NO_NUMBERS.items():
        page.type("intensity", typed, key)
        page.until(lambda said=said: f"Brightness{said}" in page.state("notice"))
        page.until(lambda: page.typed("intensity", key) == "1")
    assert not page.state("can_undo")
    for typed, number in (("1,5", 1.5), ("1.25", 1.25), ("1000", 1000.0)):
        page.type("intensity", typed, key)
        page.until(lambda number=number: page.light("key")["intensity"]["value"] == number)
        assert page.typed("intensity", key) == str(number).removesuffix(".0")
    page.input("intensity", key).send_keys(Keys.ARROW_DOWN, Keys.ARROW_DOWN, Keys.ARROW_UP)
    page.until(lambda: page.light("key")["intensity"]["value"] == 999.0)


def test_numbers_beside_each_other_and_beside_a_switch_are_read_as_text(page):
    from selenium.webdriver.common.keys import Keys

    def field(css):
        found = page.driver.find_element("css selector", css)
        page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", found)
        return found

    def retype(css, text):
        field(css).send_keys(Keys.CONTROL, "a")
        field(css).send_keys(text, Keys.ENTER)

    page.click("add-point")
    before = page.until(lambda: page.light("point")["fields"])
    position = '[data-field="position"] input'
    retype(position, "1,000")
    page.until(lambda: "Position: “1,000” is ambiguous" in page.state("notice"))
    assert page.light("point")["fields"] == before
    page.until(lambda: field(position).get_property("value") not in ("", "1,000"))
    retype(position, "0,5")
    page.until(lambda: page.light("point")["fields"] != before)
    assert next(entry for entry in page.light("point")["fields"] if entry["name"] == "position")["value"][0] == 0.5

    def occlusion():
        return next(entry for entry in page.state("model") if entry["name"] == "ambient_occlusion")

    page.trigger("edit", "model.ambient_occlusion", True)
    within = '#panel-scene [data-field="ambient_occlusion"] input[inputmode=decimal]'
    page.until(lambda: page.driver.find_elements("css selector", within))
    retype(within, "abc")
    page.until(lambda: "Ambient occlusion: “abc” is not a number." in page.state("notice"))
    retype(within, "1,5")
    page.until(lambda: occlusion()["number"] == 1.5)
    retype(within, " ")
    page.until(lambda: occlusion()["number"] is None and occlusion()["value"])


@pytest.mark.parametrize(
    ("field", "name", "label", "before"),
    [
        ("report-seconds", "seconds", "Time", 20),
        ("picture-width", "width", "Width", 1920),
        ("picture-height", "height", "Height", 1080),
    ],
)
def test_numbers_beside_the_document_are_put_back_when_they_are_refused(page, field, name, label, before):
    for typed, said in {**NO_NUMBERS, "0": "", "": ": enter a value."}.items():
        page.type(field, typed) if typed else page.input(field).send_keys("\ue009a\ue000\ue003\ue007")
        page.until(lambda said=said: f"{label}{said}" in page.state("notice"))
        page.until(lambda: page.typed(field) == str(before))
    page.type(field, "30,0")
    page.until(lambda: page.state(name) == 30)
    page.until(lambda: page.typed(field) == "30")
    page.trigger("type_number", name, before)
    page.until(lambda: page.typed(field) == str(before))


def test_no_picture_is_made_and_no_report_begun_of_a_number_that_is_none(page):
    fetched = "return fetch(arguments[0]).then(async (answer) => [answer.status, await answer.text()])"
    for size in (
        "width=1,000&height=20",
        "width=40&height=abc",
        "width=40.5&height=20",
        "width=40",
        "width=0&height=1",
    ):
        status, said = page.driver.execute_script(fetched, f"take/png?{size}")
        assert status == 400
        assert " must be a" in said
    page.trigger("report", "1,000")
    page.until(lambda: "Time: “1,000” is ambiguous" in page.state("notice"))
    assert not page.state("report")["running"]


def test_a_slider_is_moved_as_one_step(page):
    from selenium.webdriver.common.action_chains import ActionChains

    row = page.row("key")
    thumb = page.all("intensity", row)[0].find_element("css selector", "[role=slider]")
    moves = ActionChains(page.driver, duration=20).click_and_hold(thumb)
    for _ in range(6):
        moves.move_by_offset(6, 0)
    moves.release().perform()
    page.until(lambda: page.light("key")["intensity"]["value"] > 2.0 and page.state("local") == {})
    from selenium.webdriver.common.keys import Keys

    ActionChains(page.driver).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
    page.until(lambda: page.light("key")["intensity"]["value"] == 1.0)
    assert not page.state("can_undo")


def test_a_temperature_sets_the_colour_of_a_light(page):
    page.click("add-point")
    page.until(lambda: page.light("point")["selected"])
    page.type("temperature", "2700")
    page.until(lambda: np.allclose(page.light("point")["diffuse"]["value"], ph.kelvin(2700)))
    page.type("temperature", "100")
    page.until(lambda: "1667" in page.state("notice"))
    page.click("undo")
    page.until(lambda: page.light("point")["diffuse"]["hex"] == "#ffffff")


def test_a_set_up_is_chosen_by_its_picture_and_undone(page):
    before = [light["called"] for light in page.state("lights")]
    page.click("setups")
    page.until(lambda: page.all("setup-product") and page.all("setup-three-point"))
    image = page.all("setup-product")[0].find_element("css selector", "img")
    page.until(lambda: image.get_property("naturalWidth") > 30)
    page.settled(lambda: page.all("setup-product")[0].rect)
    page.click("setup-product")
    page.until(lambda: [light["kind"] for light in page.state("lights")] == ["rectangle"] * 3)
    page.click("undo")
    page.until(lambda: [light["called"] for light in page.state("lights")] == before)


def test_the_sun_by_date_and_place_follows_its_sliders(page):
    pytest.importorskip("pvlib")
    from selenium.webdriver.common.action_chains import ActionChains

    page.click("setups")
    page.settled(lambda: page.all("setup-sun")[0].rect)
    page.until(lambda: page.all("setup-sun")[0].find_element("css selector", "img").get_property("naturalWidth") > 30)
    page.click("setup-sun")
    page.until(lambda: "10:00 UTC+1 the sun is 54° high in the south-east" in page.all("sun-text")[0].text)
    page.until(lambda: 50 < page.middle().mean() < 250)
    assert [light["called"] for light in page.state("lights")] == ["sun", "sky"]
    height = page.light("sun")["intensity"]["value"]
    (hour,) = page.driver.find_elements("css selector", '[data-test="sun"] [data-field="hour"]')
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", hour)
    page.settled(lambda: hour.rect)
    thumb = hour.find_element("css selector", "[role=slider]")
    moves = ActionChains(page.driver, duration=20).click_and_hold(thumb)
    for _ in range(5):
        moves.move_by_offset(6, 0)
    moves.release().perform()
    page.until(lambda: page.state("sun")["fields"][3]["value"] > 12 and not page.state("local"))
    page.until(lambda: "south-west" in page.all("sun-text")[0].text)
    assert page.light("sun")["intensity"]["value"] != height
    page.trigger("edit", "sun.hour", 2)
    page.until(lambda: page.all("sun-text")[0].text.startswith("Night: on 21 June, 02:00 UTC+1"))
    assert 50 < page.middle().mean() < 250
    page.click("undo")
    page.click("undo")  # the whole movement of the slider
    page.until(lambda: page.state("sun")["fields"][3]["value"] == 10)
    page.click("undo")
    page.until(lambda: page.state("sun") is None and not page.all("sun"))


def test_exposure_tone_curve_and_clipping_change_the_picture_and_no_colour_of_a_file(page):
    before, middle, evaluations = page.picture(), page.middle(), page.state("evaluations")
    page.type("exposure", "-2")
    page.until(lambda: page.state("display")["exposure"]["value"] == -2)
    page.until(lambda: page.picture().mean() < before.mean() - 3)
    page.type("exposure", "0,5")
    page.until(lambda: page.state("display")["exposure"]["value"] == 0.5)
    bright = page.settled(lambda: page.picture().tolist())
    assert page.state("evaluations") <= evaluations + 2 * len(page.state("materials"))
    page.trigger("edit", "display.tone", "filmic")
    page.until(lambda: np.abs(page.picture() - np.array(bright, float)).mean() > 1)
    page.trigger("edit", "display.tone", "none")
    page.input("clipping").click()
    reds = (255, 0, 0)
    page.until(lambda: (np.abs(page.picture() - reds).max(axis=2) < 40).mean() > 0.01)
    for _ in range(5):
        page.click("undo")
    page.until(lambda: page.state("display")["exposure"]["value"] == 0)
    page.until(lambda: np.abs(page.middle() - middle).max() < 3)


def test_the_plan_follows_the_tolerance(page):
    rows = page.until(lambda: page.all("plan-row"))
    assert {row.text.split()[0] for row in rows} >= {"lights", "diffuse", "specular"}
    assert any(row.text.startswith("specular off") for row in rows)
    page.type("intensity", "0.001", page.row("fill"))
    page.type("tolerance", "0.05")
    page.until(lambda: "off by at most" in page.state("plan")["accuracy"])
    page.until(lambda: any("fill" in row.text for row in page.all("plan-row")))
    page.type("tolerance", "0")
    page.until(lambda: "exact" in page.state("plan")["accuracy"])


def test_faders_evaluate_no_light_and_the_mix_is_kept(page):
    page.until(lambda: page.all("mix"))[0].find_element("css selector", "input").click()
    page.until(lambda: page.state("mixing") and len(page.all("fader")) == 3)
    begun, shown = page.settled(lambda: page.state("evaluations")), page.middle()
    page.type("fader-gain", "0.1", page.all("fader")[0])
    page.until(lambda: page.middle().max() < 0.6 * shown.max())
    page.click("fader-solo", page.all("fader")[1])
    page.until(lambda: page.light("fill")["fader_soloed"])
    page.click("fader-solo", page.all("fader")[1])
    page.until(lambda: not page.light("fill")["fader_soloed"])
    assert page.state("evaluations") == begun
    assert f"computed {begun} times" in page.all("evaluations")[0].text
    page.click("keep-mix")
    page.until(lambda: page.light("key")["intensity"]["value"] == pytest.approx(0.1))


def test_a_second_browser_sees_the_same_and_a_reload_loses_nothing(page, served):
    page.click("add-point")
    page.until(lambda: page.light("point"))
    first = page.driver.current_window_handle
    page.driver.switch_to.new_window("tab")
    second = Page(page.driver, served.address)
    second.until(lambda: second.light("point"))
    second.type("intensity", "0.5", second.row("point"))
    second.until(lambda: second.light("point")["intensity"]["value"] == 0.5)
    page.driver.close()
    page.driver.switch_to.window(first)
    page.until(lambda: page.light("point")["intensity"]["value"] == 0.5)
    page.driver.refresh()
    page.until(lambda: page.light("point")["intensity"]["value"] == 0.5)
    page.until(lambda: page.picture().std() > 5)


@pytest.fixture
def framing(folder):
    """A function that serves a page from another host."""
    folder = folder / "framing"
    folder.mkdir()
    handler = partial(SilentHandler, directory=folder)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()

        def serve(text):
            (folder / "page.html").write_text(text)
            return f"http://127.0.0.1:{server.server_port}/page.html"

        yield serve
        server.shutdown()


class SilentHandler(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def test_a_studio_that_others_can_have_works_in_a_frame_of_another_host(driver, folder, framing):
    mesh = folder / "framed.ply"
    pv.Sphere(theta_resolution=24, phi_resolution=24).save(mesh)
    served = Served(mesh, "--host", "0.0.0.0")
    first = driver.current_window_handle
    driver.switch_to.new_window("tab")
    try:
        _, _, port, token, end = re.split("[:/]+", served.address)
        assert (len(token), end) == (32, "")
        address = f"http://localhost:{port}/{token}/"
        style = "position: fixed; inset: 0; width: 100%; height: 100%; border: 0"
        frame = f'<iframe src="{address}" style="{style}"></iframe>'
        page = Page(driver, framing(f"<!doctype html>{frame}"), in_frame=True)
        shown = page.middle()
        page.type("intensity", "0", page.row("key"))
        page.until(lambda: page.light("key")["intensity"]["value"] == 0)
        page.until(lambda: page.middle().max() < 0.8 * shown.max())
        mine = "return [document.referrer, document.cookie, location.href, ...performance.getEntriesByType('resource')"
        mine += ".map((entry) => entry.name)]"
        referrer, cookie, *places = page.driver.execute_script(mine)
        assert (token in referrer, cookie) == (False, "")
        assert all(place.startswith(address) for place in places if place.startswith("http"))
        rig = "return fetch('take/rig').then((answer) => answer.json())"
        page.until(lambda: page.driver.execute_script(rig)["lights"][0]["intensity"] == 0)
        pv.Cube().save(folder / "framed.stl")
        bring(page, "mesh", folder / "framed.stl")
        page.until(lambda: page.state("title") == "framed: 24 points")
    finally:
        driver.switch_to.default_content()
        driver.close()
        driver.switch_to.window(first)
        served.close()


def test_malformed_messages_are_refused_and_harm_nobody(page, served):
    import msgpack
    from aiohttp import ClientSession, WSMsgType
    from wslink.chunking import generate_chunks

    good = {"wslink": "1.0", "id": "rpc:c0:1", "method": "trame.state.get", "args": []}
    hello = {"wslink": "1.0", "id": "system:c0:0", "method": "wslink.hello", "args": [{"secret": "wslink-secret"}]}
    bad = [
        *({**good, "method": method} for method in ("application.exit", "trame.force.push", "trame.rca.push", 5, None)),
        *({**good, "args": args} for args in ("x", {"a": 1}, None)),
        *({**good, "id": key} for key in (None, 7, [], "x" * 500)),
        {**good, "kwargs": {"self": 1}},
        {**good, "method": "trame.state.update", "args": [[{"key": "lights", "value": []}]]},
        *({**good, "method": "trame.lifecycle.update", "args": [name]} for name in ("server_ready", "exception", [])),
        *(
            {**good, "method": "trame.trigger", "args": args}
            for args in ([], ["nobody", [], {}], ["undo", [], {"x": 1}])
        ),
        *({**good, "method": "trame.trigger", "args": [name, [{"a": 1}], {}]} for name in ("edit", "slide", "add")),
        *({**good, "method": "trame.rca.event", "args": args} for args in ([], ["a", "b", {}], ["a", "b", None])),
        *({**good, "method": "trame.rca.size", "args": args} for args in (["a", "b", {"w": "x"}], [[], [], []])),
        *([], 5, "text", [good], {}),
    ]

    def framed(message):
        return next(generate_chunks(msgpack.packb(message), 0))

    raw = [b"", bytes(1), bytes(40), b"\xff" * 12, (2**31).to_bytes(12, "little"), b"\x01" + bytes(7) + b"\xff" * 4]

    async def ask(end, frame, *, text=False):
        """Send a frame and return the answer, skipping pictures and states."""
        await (end.send_str(frame) if text else end.send_bytes(frame))
        while True:
            got = await end.receive(timeout=60)
            assert got.type == WSMsgType.BINARY, got
            answer = msgpack.unpackb(got.data[12:])
            if not answer["id"].startswith("publish:"):
                return answer

    async def main():
        async with ClientSession() as session, session.ws_connect(f"{served.address}ws") as end:
            answers = [await ask(end, framed(good))]  # before a greeting
            assert "result" in await ask(end, framed(hello))
            answers += [await ask(end, framed(message)) for message in bad]
            answers += [await ask(end, frame) for frame in raw]
            answers.append(await ask(end, "text", text=True))
            assert "result" in await ask(end, framed(good))
            for _ in range(10):  # disconnect in the middle of an answer
                async with session.ws_connect(f"{served.address}ws") as going:
                    await going.send_bytes(framed(hello))
                    for _ in range(5):
                        await going.send_bytes(framed(good))
                    going._response.close()
            assert "result" in await ask(end, framed(good))
            return answers

    answers = asyncio.run(main())
    assert all("error" in answer and "data" not in answer["error"] for answer in answers)
    assert "/" not in json.dumps(answers)  # no path
    page.click("add-point")
    page.until(lambda: page.light("point") or page.light("point 2"))


def download(page, home, *names):
    for name in names:
        page.download("rig" if name.endswith("-rig.json") else name.rpartition(".")[2], home / name)


def made_again(script):
    """Run a script and check that its result equals the downloaded file exactly."""
    lit = pv.read(script.with_suffix(".vtp"))
    done = subprocess.run([sys.executable, script.name], cwd=script.parent, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(pv.read(script.with_suffix(".vtp"))["phong"], lit["phong"])
    return lit


def test_what_is_taken_home_is_made_again_by_its_script(page, folder, ball):
    page.click("add-spot")
    page.trigger("choose_material", 0, "gold")
    page.until(lambda: page.state("materials")[0]["preset"] == "gold" and "SpotLight" in page.state("script"))
    page.until(lambda: page.middle()[0] > page.middle()[2] + 40)
    page.trigger("choose_reflectance", 0, "pbr")
    fields = page.until(lambda: page.state("materials")[0]["reflectance_fields"])
    assert [field["name"] for field in fields] == ["metallic", "roughness"]
    page.trigger("edit", "model.shadows", True)
    page.until(lambda: "shadows=True" in page.state("script"))
    home = folder / "home"
    home.mkdir()
    (home / "ball.ply").write_bytes(ball.read_bytes())
    page.type("picture-width", "320")
    page.type("picture-height", "200")
    download(page, home, "ball-rig.json", "ball-lit.vtp", "ball-lit.ply", "ball-lit.glb", "ball.png", "ball-lit.py")
    made_again(home / "ball-lit.py")
    assert json.loads((home / "ball-rig.json").read_text())["lights"][-1]["type"] == "spot"
    assert pv.read(home / "ball.png").dimensions == (320, 200, 1)


def test_a_texture_is_brought_and_its_script_gives_the_same_bits(page, folder):
    home = folder / "textured"
    home.mkdir()
    pv.Plane(i_resolution=20, j_resolution=20).save(home / "sheet.vtp")
    stripes = np.uint8(np.indices((16, 16))[0] % 2 * 255)
    pv.Texture(np.stack([stripes, stripes // 2, 255 - stripes], axis=2)).to_image().save(home / "stripes.png")
    bring(page, "mesh", home / "sheet.vtp")
    page.until(lambda: page.state("title").startswith("sheet"))
    bring(page, "texture", home / "stripes.png")
    page.until(lambda: "stripes.png" in page.state("script"))
    page.until(lambda: page.all("remove-map"))
    page.trigger("edit", "surfaces.feature_angle", 0)
    page.until(lambda: "feature_angle=0.0" in page.state("script"))
    (home / "sheet-lit.py").write_text(page.state("script"))
    download(page, home, "sheet-lit.vtp")
    lit = made_again(home / "sheet-lit.py")
    assert lit.n_points == 4 * 400
    assert np.ptp(lit["phong"][:, 2]) > 0.3


def test_an_array_is_chosen_with_its_colormap_and_its_script_gives_the_same_bits(page, folder):
    from selenium.webdriver.common.keys import Keys

    home = folder / "hills"
    home.mkdir()
    pv.examples.load_random_hills().save(home / "hills.vtp")
    bring(page, "mesh", home / "hills.vtp")
    page.until(lambda: page.state("title").startswith("hills"))

    def chosen():
        return page.state("materials")[0]["colormap"]

    def choose(name, text, typed=""):
        field = page.all(name)[0]
        page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
        page.until(lambda: field.click() is None)  # the previous list may still be closing
        if typed:
            field.find_element("css selector", "input").send_keys(Keys.CONTROL, "a")
            field.find_element("css selector", "input").send_keys(typed)
        item = "//div[contains(@class, 'v-overlay--active')]//div[contains(@class, 'v-list-item-title')]"
        item += f"[normalize-space(.)='{text}']"
        page.until(lambda: page.driver.find_element("xpath", item).click() is None)

    grey = page.settled(lambda: np.ptp(page.picture(), axis=2).max())
    choose("colour-by", "Elevation")
    page.until(lambda: chosen()["scalars"] == "Elevation")
    page.until(lambda: np.ptp(page.picture(), axis=2).max() > grey + 40)
    choose("colormap", "terrain", typed="terrain")
    page.until(lambda: chosen()["cmap"] == "terrain")
    page.type("colormap-low", "-2")
    page.until(lambda: chosen()["low"] == -2)
    page.until(lambda: "ph.Colormap(scalars='Elevation', cmap='terrain', clim=(-2.0, " in page.state("script"))
    (home / "hills-lit.py").write_text(page.state("script"))
    download(page, home, "hills-lit.vtp")
    made_again(home / "hills-lit.py")
    page.type("colormap-high", "-3")
    page.until(lambda: "the smaller first" in page.state("notice"))
    assert chosen()["low"] == -2
    page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", page.all("colormap")[0])
    page.until(lambda: page.click("colormap-range") is None)
    page.until(lambda: chosen()["low"] > 0)
    page.driver.save_screenshot(str(folder / "colormap.png"))


def test_meshes_and_rigs_are_brought_and_what_is_broken_is_refused(page, folder):
    rig = ph.Scene([ph.PointLight((1, 1, 1), name="lamp")], light_model=ph.LightModel(ambient=0.5))
    rig.save(folder / "rig.json", materials={"default": "gold"})
    bring(page, "rig", folder / "rig.json")
    page.until(lambda: [light["called"] for light in page.state("lights")] == ["lamp"])
    page.until(lambda: page.state("materials")[0]["preset"] == "gold")
    page.click("undo")
    page.until(lambda: page.light("fill"))
    bad = {
        "broken.ply": ("mesh", "ply\nformat ascii 1.0\n", "broken.ply."),
        "other.json": ("rig", "{}", 'a JSON object with "format"'),
        "newer.json": ("rig", '{"format": "pvphong scene", "version": 9}', "ersion must be"),
        "thief.json": ("rig", (folder / "rig.json").read_text().replace("0.75164", '"/etc/x.png"'), "must be"),
    }
    for name, (what, text, said) in bad.items():
        (folder / name).write_text(text)
        bring(page, what, folder / name)
        page.until(lambda said=said: said in page.state("notice"))
        assert str(folder) not in page.state("notice")
        page.until(lambda: not page.state("busy"))
    assert page.light("fill")
    pv.Cube().save(folder / "box.stl")
    bring(page, "mesh", folder / "box.stl")
    page.until(lambda: page.state("title") == "box: 24 points" and len(page.state("lights")) == 3)
    page.trigger("open_example", "nut")
    page.until(lambda: page.state("title").startswith("nut") and "load_nut" in page.state("script"))


# --- background computations


def test_the_view_is_refined_when_an_edit_is_over_and_that_is_cancelled(page):
    page.trigger("open_example", "airplane")
    page.until(lambda: page.state("title").startswith("airplane"))
    switch(page, "refine")
    page.until(lambda: page.all("refined")[0].text == "refining")
    page.until(lambda: page.all("refined")[0].text.endswith(" points added"))
    assert not page.all("refining")
    page.until(lambda: "1,513 points" in page.state("title"))
    page.type("refine-tolerance", "0.0001")  # takes longer
    page.until(lambda: page.all("refining"))
    page.click("cancel-refining")
    page.until(lambda: page.all("refined")[0].text.endswith("cancelled"))
    assert not page.all("refining")
    page.type("refine-tolerance", "0.05")
    page.until(lambda: page.all("refined")[0].text.endswith(" points added"))
    switch(page, "refine")
    page.until(lambda: page.all("refined")[0].text == "")
    page.click("undo")
    page.until(lambda: page.all("refined")[0].text.endswith(" points added"))


def test_light_that_bounces_is_gathered_while_the_page_is_live(page, folder):
    """The mesh takes seconds to gather: first it is cancelled, then it finishes."""
    from selenium.webdriver.common.keys import Keys

    pv.ParametricTorus(ringradius=1.0, crosssectionradius=0.45, u_res=160, v_res=160).save(folder / "ring.vtp")
    bring(page, "mesh", folder / "ring.vtp")
    page.until(lambda: page.state("title").startswith("ring") and len(page.state("lights")) == 3)
    page.until(lambda: not page.state("busy"))

    def bounces():
        return next(entry for entry in page.state("model") if entry["name"] == "bounces")["value"]

    def bounce(count):
        field = page.driver.find_element("css selector", '#panel-scene [data-field="bounces"] input')
        page.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", field)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(str(count), Keys.ENTER)

    def brightness():
        return page.picture()[60:-150].mean()  # without the texts above and below

    plain = page.settled(brightness)
    bounce(2)
    page.until(lambda: page.all("gathering"))
    page.click("cancel-bounces")
    page.until(lambda: page.all("notice")[0].text.endswith("bounces = 0, as before."))
    page.until(lambda: not page.all("gathering") and bounces() == 0)
    assert page.settled(brightness) == pytest.approx(plain, abs=0.2)
    bounce(2)
    shown = set()
    page.until(lambda: shown.add(page.state("gathering")) or (page.state("gathering") or 0) > 0)
    page.trigger("edit", page.light("key")["intensity"]["key"], 0.5)
    page.until(lambda: page.light("key")["intensity"]["value"] == 0.5)
    assert page.all("gathering")  # the edit does not wait for the light
    page.until(lambda: shown.add(page.state("gathering")) or not page.all("gathering"), seconds=240.0)
    assert len(shown - {None}) > 1  # progress was shown
    assert bounces() == 2
    lit = page.settled(brightness)
    page.trigger("edit", "model.bounces", 0)
    page.until(lambda: bounces() == 0 and abs(brightness() - lit) > 0.3)
