"""No damaged file ends a command otherwise than with its status and one line, and none is lit by what is in memory."""

import json
import subprocess
import sys

import fuzzing
import pytest


@pytest.mark.parametrize("count", [pytest.param(40, id="few"), pytest.param(10_000, id="many", marks=pytest.mark.long)])
def test_damaged_files_are_refused_or_read_as_they_are(count):
    command = [sys.executable, "-W", "ignore", fuzzing.__file__, str(count)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    report = json.loads(done.stdout)
    assert report["files"] == count
    assert report["faults"] == []
    assert report["cut_and_accepted"] == {}
    statuses = {words.split()[1] for words in report["statuses"]}
    assert {"0", "2"} <= statuses  # some are refused, and not all
