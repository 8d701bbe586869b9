"""Whatever is written is there whole or not at all, though the writer is killed or meets a limit."""

import json
import subprocess
import sys

import interrupting
import pytest


@pytest.mark.parametrize(
    ("kills", "limits"), [pytest.param(16, 3, id="few"), pytest.param(500, 20, id="many", marks=pytest.mark.long)]
)
def test_the_old_file_is_there_or_the_new_one(kills, limits):
    command = [sys.executable, "-W", "ignore", interrupting.__file__, str(kills), str(limits)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["faults"] == []
    assert report["kills"] == kills
    assert report["in mid-write"] > 0
