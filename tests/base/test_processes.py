"""What a process that reads files tells the one that watches it; `tests/cli/test_supervisor.py` has both at work."""

import os
import resource
import sys

import pytest

from pvphong.base import processes
from pvphong.base.processes import reading


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.skipif(sys.platform != "linux", reason="memory is not limited there")
def test_the_watch_and_the_limit_of_memory_end_with_the_reading_even_if_it_fails(monkeypatch, fails):
    listening, speaking = os.pipe()
    monkeypatch.setattr(processes, "watcher", speaking)
    before = resource.getrlimit(resource.RLIMIT_DATA)

    def read():
        with reading("whole.vtm"):
            with reading("block.vtp"):  # part of the same reading
                assert 0 < resource.getrlimit(resource.RLIMIT_DATA)[0] < 2**50
            assert 0 < resource.getrlimit(resource.RLIMIT_DATA)[0] < 2**50
            if fails:
                raise ValueError("damaged")

    if fails:
        with pytest.raises(ValueError, match="damaged"):
            read()
    else:
        read()
    os.close(speaking)
    with os.fdopen(listening, "rb") as end:
        assert end.read() == f"reading {processes.SECONDS} whole.vtm\0done \0".encode()
    assert resource.getrlimit(resource.RLIMIT_DATA) == before
