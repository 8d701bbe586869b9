"""One of many gets a lock, and what was taken of a file that has gone is none."""

from pathlib import Path

import pytest

from pvphong.base import files
from pvphong.base.files import locked


@pytest.fixture
def path(tmp_path):
    return tmp_path / "owner.lock"


def test_one_is_alone_at_a_time(path):
    with locked(path) as first:
        with locked(path) as second:
            assert (first, second) == (True, False)
        with locked(path) as third:
            assert not third
    with locked(path) as later:
        assert later
    assert path.exists()


def test_who_does_not_make_the_file_is_alone_only_where_it_is(path):
    with locked(path, makes=False) as is_alone:
        assert not is_alone
    assert not path.exists()
    path.touch()
    with locked(path, makes=False) as is_alone:
        assert is_alone


def test_where_it_cannot_be_made_nobody_is_alone(path):
    with locked(path / "no folder") as is_alone:
        assert not is_alone


@pytest.mark.parametrize("then", [Path.exists, Path.touch], ids=["gone", "another one"])
def test_a_file_that_was_removed_before_it_could_be_locked_is_not_the_one(path, monkeypatch, then):
    take = files._take

    def late(file):
        path.unlink()
        then(path)
        take(file)

    monkeypatch.setattr(files, "_take", late)
    with locked(path) as is_alone:
        assert not is_alone


def test_where_files_cannot_be_locked_nobody_is_alone(path, monkeypatch):
    def refuse(_):
        raise OSError

    monkeypatch.setattr(files, "_take", refuse)
    with locked(path) as is_alone:
        assert not is_alone
