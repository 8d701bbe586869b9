"""Atomic writes of files, and locks."""

import os
import socket
import stat
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

import pytest

from pvphong.base import files
from pvphong.base.files import locked, written_aside


@pytest.fixture
def target(tmp_path, monkeypatch):
    """A file to be written in the working folder, which is otherwise empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path / "scene.json"


def test_the_suffix_is_in_small_letters_while_it_is_written(target):
    """Some writers recognize their suffix only in lower case."""
    with written_aside("PICTURE.SVG") as aside:
        assert aside.suffix == ".svg"
        aside.write_text("whole")
    assert [path.name for path in target.parent.iterdir()] == ["PICTURE.SVG"]


@pytest.mark.parametrize("old", [None, "old"])
@pytest.mark.parametrize("named", [lambda path: path, str, lambda path: path.name], ids=["path", "string", "bare name"])
def test_the_written_file_itself_takes_the_place_and_leaves_nothing_beside_it(target, named, old):
    """The file is moved atomically; a copy could be seen, or left, half written."""
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


# --- attributes that are kept ---


def test_mode_and_links_are_kept_and_a_new_file_has_the_mode_of_any(target):
    Path("any").write_text("")
    with written_aside(target) as aside:
        aside.write_text("old")
    assert target.stat().st_mode == Path("any").stat().st_mode
    target.chmod(0o600)
    Path("link").symlink_to("scene.json")
    with written_aside("link") as aside:
        aside.write_text("new")
    assert Path("link").is_symlink()
    assert target.read_text() == "new"
    assert stat.S_IMODE(target.stat().st_mode) == 0o600


def nothing(_name, _monkeypatch):
    pass


def denied(_name, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(tempfile, "mkdtemp", refuse)


def a_socket(name, _monkeypatch):
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(name)


@pytest.mark.parametrize(
    ("path", "make", "message"),
    [
        ("scene.json", lambda name, _: Path(name).symlink_to(name), "a file.*Too many levels"),
        ("scene.json", a_socket, "a file.*a pipe or a character device"),
        ("x" * 300, nothing, "a file.*File name too long"),
        ("nowhere/a.txt", nothing, r"in a folder that exists; got .*a\.txt\. Create .*nowhere first"),
        (".", nothing, "a file; .*It is a folder"),
        ("a.txt", denied, "in a folder that can be written to; got .*Permission denied"),
    ],
    ids=["a link to itself", "a socket", "a long name", "no folder", "a folder", "a folder of others"],
)
@pytest.mark.usefixtures("target")
def test_what_can_neither_be_replaced_nor_written_into_is_refused(monkeypatch, path, make, message):
    make(path, monkeypatch)
    before = os.listdir()
    with pytest.raises(ValueError, match=f"^path must be {message}"), written_aside(path):
        pytest.fail("the path should have been refused")
    assert os.listdir() == before


def test_a_pipe_is_written_into_and_stays(target):
    os.mkfifo(target)
    received = []
    reader = threading.Thread(target=lambda: received.append(target.read_text()))
    reader.start()
    with written_aside(target) as aside:
        aside.write_text("poured")
    reader.join(10)
    assert received == ["poured"]
    assert stat.S_ISFIFO(target.stat().st_mode)
    assert os.listdir() == ["scene.json"]


def test_a_device_is_written_into_and_stays():
    for device, refused in (("/dev/null", nullcontext()), ("/dev/full", pytest.raises(ValueError, match="No space"))):
        before = os.stat(device).st_rdev
        with refused, written_aside(device) as aside:
            aside.write_text("poured")
        assert stat.S_ISCHR(os.stat(device).st_mode)
        assert os.stat(device).st_rdev == before


# --- folders of killed processes ---

WRITER = """
import signal, sys
from pvphong.base.files import written_aside
with written_aside(sys.argv[1]) as aside:
    aside.write_text("half")
    print(aside.parent.name, flush=True)
    signal.pause()
"""


def folders():
    return [name for name in os.listdir() if name.startswith(files.PREFIX)]


def test_what_a_killed_writer_left_is_cleared_by_the_next_and_a_living_writers_folder_is_not(target):
    def write():
        with written_aside(target) as aside:
            aside.write_text("new")
            return sorted(folders()), aside.parent.name

    target.write_text("old")
    command = [sys.executable, "-c", WRITER, str(target)]
    with ExitStack() as held:
        dead, living = (held.enter_context(subprocess.Popen(command, stdout=subprocess.PIPE, text=True)) for _ in "12")
        names = [writer.stdout.readline().strip() for writer in (dead, living)]
        dead.kill()
        dead.wait()
        assert (sorted(folders()), target.read_text()) == (sorted(names), "old")
        found, own = write()
        assert found == sorted([names[1], own])
        living.kill()
        living.wait()
    write()
    assert (folders(), target.read_text()) == ([], "new")


@pytest.mark.parametrize("removed", range(5))
def test_who_is_killed_while_removing_a_folder_leaves_what_the_next_can_clear(target, monkeypatch, removed):
    """The lock is removed last, because a nonempty folder without a lock belongs to someone else."""
    unlink, count = os.unlink, 0

    def killed(*path, **how):
        nonlocal count
        if count == removed:
            raise KeyboardInterrupt
        count += 1
        unlink(*path, **how)

    def write(patch):
        with written_aside(target) as aside:
            aside.write_text("old")
            for name in "abcd":
                aside.with_name(name).touch()
            patch.setattr(os, "unlink", killed)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        write(patch)
    assert len(folders()) == 1
    with written_aside(target) as aside:
        aside.write_text("new")
    assert folders() == []


def test_a_folder_with_something_in_it_is_left_alone_and_an_empty_one_is_cleared(target):
    """A folder is left empty by a process that is killed before it locks it, or just before it removes it."""
    for name in ("keepsake", "12345678"):
        Path(f".pvphong-{name}").mkdir()
    Path(".pvphong-keepsake/mine").write_text("mine")
    with written_aside(target) as aside:
        aside.write_text("new")
    assert folders() == [".pvphong-keepsake"]


def test_a_writer_whose_new_folder_is_cleared_makes_the_next(target, monkeypatch):
    """Another writer removes the folder before the first has created its lock."""

    @contextmanager
    def late(path, **how):
        if not made:
            path.parent.rmdir()
        made.append(path.parent)
        with locked(path, **how) as is_alone:
            yield is_alone

    made = []
    monkeypatch.setattr(files, "locked", late)
    with written_aside(target) as aside:
        aside.write_text("new")
    assert (len(made), target.read_text(), folders()) == (2, "new", [])


@pytest.mark.parametrize("lost", [5, 1000], ids=["by turns", "no file can be locked"])
def test_a_writer_whose_folder_another_is_clearing_makes_the_next(target, monkeypatch, lost):
    """Another writer takes the lock of a new folder before its owner does, and removes its content."""

    @contextmanager
    def late(path, *, makes=True):
        nonlocal lost
        assert makes
        lost -= 1
        if lost >= 0:
            tried.append(path.parent)
            yield False
        else:
            with locked(path) as is_alone:
                yield is_alone

    tried = []
    monkeypatch.setattr(files, "locked", late)
    with written_aside(target) as aside:
        assert (aside.parent in tried) == (lost > 0)
        aside.write_text("new")
        assert folders() == [aside.parent.name]
    assert 5 <= len(set(tried)) < 20
    assert os.listdir() == ["scene.json"]


def test_many_writers_at_once_each_write_a_whole_file(target):
    """The writers are threads here; the lock works the same between processes."""

    def write(letter):
        with written_aside(target) as aside:
            aside.write_text(letter * 10_000)
        return target.read_text()

    with ThreadPoolExecutor(8) as threads:
        seen = list(threads.map(write, 20 * "abcdefgh"))
    assert all(len(text) == 10_000 and len(set(text)) == 1 for text in seen)
    assert os.listdir() == ["scene.json"]


# --- locks: only one of many gets the lock, and a lock on a removed file does not count ---


@pytest.fixture
def path(tmp_path):
    return tmp_path / "owner.lock"


def is_alone(path, **how):
    with locked(path, **how) as result:
        return result


def test_one_is_alone_at_a_time_and_who_does_not_make_the_file_only_where_it_is(path):
    assert not is_alone(path, makes=False)
    assert not path.exists()
    with locked(path) as first:
        assert [first, is_alone(path), is_alone(path)] == [True, False, False]
    assert is_alone(path)
    assert is_alone(path, makes=False)
    assert not is_alone(path / "no folder")


@pytest.mark.parametrize("then", [Path.exists, Path.touch, None], ids=["gone", "another one", "no locks"])
def test_where_the_file_was_removed_before_it_could_be_locked_or_none_can_be_nobody_is_alone(path, monkeypatch, then):
    take = files._take

    def late(file):
        if then is None:
            raise OSError
        path.unlink()
        then(path)
        take(file)

    monkeypatch.setattr(files, "_take", late)
    assert not is_alone(path)
