"""A file is there whole or not at all."""

import os
import tempfile

import pytest

from pvphong.base.files import written_aside


def test_writes_the_file_and_leaves_nothing_beside_it(tmp_path):
    target = tmp_path / "scene.json"
    with written_aside(target) as aside:
        assert aside != target
        assert aside.suffix == ".json"  # writers choose their format by it
        aside.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert os.listdir(tmp_path) == ["scene.json"]


def test_the_written_file_itself_takes_the_place(tmp_path):
    """It is moved there in one step; a copy could be seen, or left, half written."""
    target = tmp_path / "scene.json"
    target.write_text("old")
    with written_aside(target) as aside:
        aside.write_text("new")
        written = aside.stat().st_ino
    assert target.stat().st_ino == written


def test_takes_a_string(tmp_path):
    with written_aside(str(tmp_path / "a.txt")) as aside:
        aside.write_text("whole")
    assert (tmp_path / "a.txt").read_text() == "whole"


def test_takes_a_bare_name_in_the_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with written_aside("a.txt") as aside:
        aside.write_text("whole")
    assert os.listdir(tmp_path) == ["a.txt"]


def test_replaces_an_old_file(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    with written_aside(target) as aside:
        aside.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"


@pytest.mark.parametrize("old", [None, "old"])
@pytest.mark.parametrize(
    ("error", "seen", "message"),
    [
        (RuntimeError, RuntimeError, "^stopped$"),
        (KeyboardInterrupt, KeyboardInterrupt, "^stopped$"),
        (OSError, ValueError, r"^path must be a file that can be written; got .*a\.txt \(stopped\)"),
    ],
)
def test_a_failure_leaves_what_was_there(tmp_path, old, error, seen, message):
    target = tmp_path / "a.txt"
    if old:
        target.write_text(old)

    def fail():
        with written_aside(target) as aside:
            aside.write_text("half")
            raise error("stopped")

    with pytest.raises(seen, match=message):
        fail()
    assert os.listdir(tmp_path) == (["a.txt"] if old else [])
    assert not old or target.read_text() == old


def test_a_writer_that_leaves_more_files_is_tidied_up(tmp_path):
    with written_aside(tmp_path / "a.txt") as aside:
        aside.write_text("whole")
        aside.with_name("more.txt").write_text("left over")
    assert os.listdir(tmp_path) == ["a.txt"]


def enter(path):
    with written_aside(path):
        pytest.fail("the path should have been refused")


def test_the_folder_must_be_there(tmp_path):
    with pytest.raises(
        ValueError, match=r"^path must be in a folder that exists; got .*a\.txt\. Create .*nowhere first"
    ):
        enter(tmp_path / "nowhere" / "a.txt")
    assert os.listdir(tmp_path) == []


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(ValueError, match=r"^path must be a file; .*It is a folder"):
        enter(tmp_path)
    assert tmp_path.is_dir()


def test_a_folder_that_cannot_be_written_to(tmp_path, monkeypatch):
    def denied(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "mkdtemp", denied)
    with pytest.raises(ValueError, match=r"^path must be in a folder that can be written to; got .*Permission denied"):
        enter(tmp_path / "a.txt")
