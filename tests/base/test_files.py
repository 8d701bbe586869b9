"""A file is there whole or not at all."""

import os
import tempfile

import pytest

from pvphong.base.files import written_aside


@pytest.fixture
def target(tmp_path, monkeypatch):
    """A file to be written in the working folder, which has nothing else in it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path / "scene.json"


@pytest.mark.parametrize("old", [None, "old"])
@pytest.mark.parametrize("named", [lambda path: path, str, lambda path: path.name], ids=["path", "string", "bare name"])
def test_the_written_file_itself_takes_the_place_and_leaves_nothing_beside_it(target, named, old):
    """It is moved there in one step; a copy could be seen, or left, half written."""
    if old:
        target.write_text(old)
    with written_aside(named(target)) as aside:
        assert aside != target
        assert aside.suffix == ".json"  # writers choose their format by it
        aside.write_text("whole")
        aside.with_name("more.txt").write_text("left over")
        written = aside.stat().st_ino
        assert not target.exists() if old is None else target.read_text() == old
    assert target.read_text() == "whole"
    assert target.stat().st_ino == written
    assert os.listdir() == ["scene.json"]


@pytest.mark.parametrize("old", [None, "old"])
@pytest.mark.parametrize(
    ("error", "seen", "message"),
    [
        (RuntimeError, RuntimeError, "^stopped$"),
        (KeyboardInterrupt, KeyboardInterrupt, "^stopped$"),
        (OSError, ValueError, r"^path must be a file that can be written; got .*scene\.json \(stopped\)"),
    ],
)
def test_a_failure_leaves_what_was_there(target, old, error, seen, message):
    if old:
        target.write_text(old)

    def fail():
        with written_aside(target) as aside:
            aside.write_text("half")
            raise error("stopped")

    with pytest.raises(seen, match=message):
        fail()
    assert os.listdir() == (["scene.json"] if old else [])
    assert not old or target.read_text() == old


def denied(*_, **__):
    raise PermissionError(13, "Permission denied")


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("nowhere/a.txt", r"a folder that exists; got .*a\.txt\. Create .*nowhere first"),
        (".", "a file; .*It is a folder"),
        ("a.txt", "a folder that can be written to; got .*Permission denied"),
    ],
)
def test_a_place_where_no_file_can_be_is_refused(target, monkeypatch, place, message):
    if place == "a.txt":
        monkeypatch.setattr(tempfile, "mkdtemp", denied)
    with pytest.raises(ValueError, match=f"^path must be (in )?{message}"), written_aside(target.parent / place):
        pytest.fail("the path should have been refused")
    assert os.listdir() == []
