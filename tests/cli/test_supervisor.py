"""The command line's parent: after any crash at most one line, the right status, and no files or processes left.

The work here is a line of Python in the place of the commands, so that a test takes a fraction of a second.
"""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import pvphong

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="nothing is supervised there")

DRIVER = """
import os, signal, sys, time, types
from pvphong.base import processes
from pvphong.cli import supervisor
processes.SECONDS = 0.5
supervisor.FORKS = {forks}
commands = types.ModuleType("pvphong.cli.app")
def main():
    exec(sys.argv[1], dict(globals()))
    return int(sys.argv[2])
commands.main = main
sys.modules["pvphong.cli.app"] = commands
sys.exit(supervisor.main())
"""
READING = "from pvphong.base.processes import reading\nwith reading('mesh.vtk'): "
WRITING = """
from pvphong.base.files import written_aside
with written_aside("scene.json") as aside:
    aside.write_text("half")
    print(flush=True)
    """


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def start(work, *more, forks=True, status=0):
    driver = ["-W", "ignore", "-c", DRIVER.format(forks=forks), work, str(status), *more]
    return subprocess.Popen(
        [sys.executable, *driver], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def run(work, *more, **how):
    process = start(work, *more, **how)
    out, err = process.communicate(timeout=60)
    return process.returncode, out, err


def alive(process):
    """Return True if a process is running and not a zombie."""
    try:
        with open(f"/proc/{process}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_parent_is_light():
    heavy = {"numpy", "pyvista", "vtkmodules", "typing", "re"}
    code = f"import sys, pvphong.cli; sys.exit(bool({heavy} & set(sys.modules)))"
    where = os.environ | {"PYTHONPATH": str(Path(pvphong.__file__).parents[1])}  # without site-packages
    assert subprocess.run([sys.executable, "-S", "-c", code], env=where, check=False).returncode == 0


@pytest.mark.parametrize("forks", [True, False])
@pytest.mark.parametrize("status", [0, 1])
def test_the_works_output_and_status_are_the_commands(forks, status):
    work = "print('out'); print('err', file=sys.stderr)"
    assert run(work, forks=forks, status=status) == (status, "out\n", "err\n")


KILLED = "A library crashed ({}); an input file may be corrupt. --verbose shows its output."
MESH = "mesh must be a mesh file that PyVista can read; got mesh.vtk. "
CRASHES = {
    **{
        f"os.kill(os.getpid(), signal.{name})": KILLED.format(name)
        for name in ("SIGSEGV", "SIGABRT", "SIGBUS", "SIGFPE", "SIGILL", "SIGXCPU")
    },
    "os.kill(os.getpid(), 9)": "The process was killed, probably because memory ran out.",
    READING + "os.abort()": MESH + KILLED.format("SIGABRT"),
    READING + "\n with reading('block.vtp'): pass\n time.sleep(60)": MESH
    + "Reading timed out: no data from the disk for 0 s.",
}


@pytest.mark.parametrize(("work", "line"), CRASHES.items())
def test_a_crash_is_one_line_and_status_2(work, line):
    """The message names the file being read. A reader that does not finish is killed."""
    assert run(work) == (2, "", f"error: {line}\n")
    if work.endswith("signal.SIGABRT)"):
        assert run(work, forks=False) == (2, "", f"error: {line}\n")


def test_a_crash_after_the_work_is_none():
    """Libraries may crash when they are unloaded."""
    assert run("import atexit; atexit.register(os.abort); print('done')", status=1) == (1, "done\n", "")


def test_a_reader_that_is_slow_but_reads_on_is_waited_for():
    slow = "[(time.sleep(0.3), open('big', 'rb').read()) for _ in range(5)]; print('read')"
    with open("big", "wb") as file:
        file.write(bytes(10_000))
    assert run(READING + slow) == (0, "read\n", "")


WHOLE = """
import resource
from pvphong.base.processes import reading
limit = lambda: resource.getrlimit(resource.RLIMIT_DATA)[0]
old = limit()
try:
    with reading("whole.vtm"):
        with reading("block.vtp"):
            pass
        print(0 < limit() < 2**50)
        raise ValueError
except ValueError:
    print(old == limit())
time.sleep(1)
"""


def test_memory_and_time_are_limited_while_a_file_is_read_with_its_parts_even_if_it_fails():
    assert run(WHOLE) == (0, "True\nTrue\n", "")


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_an_interruption_ends_quietly_and_leaves_nothing(number, status):
    """Signals end the work even during C code, in which Python's handlers do not run."""
    process = start(WRITING + "import ctypes; ctypes.CDLL(None).sleep(60)")
    process.stdout.readline()
    assert len(os.listdir()) == 1
    process.send_signal(number)
    assert process.communicate(timeout=20) == ("", "")
    assert process.returncode == status
    assert os.listdir() == []


@pytest.mark.parametrize("forks", [True, False])
def test_an_interruption_of_a_parent_that_has_just_begun_leaves_no_child_running(forks):
    """The signal arrives after the fork and before the handlers are set."""
    begin = "fork" if forks else "posix_spawn"
    driver = f"""
import os, signal
begin = os.{begin}
def interrupted(*given):
    process = begin(*given)
    if process:
        os.kill(os.getpid(), signal.SIGTERM)
    return process
os.{begin} = interrupted
""" + DRIVER.format(forks=forks)
    given = [sys.executable, "-W", "ignore", "-c", driver, "time.sleep(60)", "0"]
    found = subprocess.run(given, capture_output=True, text=True, timeout=20)  # until the pipes close
    assert (found.returncode, found.stdout, found.stderr) == (143, "", "")


def test_a_worker_that_is_killed_in_mid_write_leaves_nothing():
    status, _, err = run(WRITING + "os.kill(os.getpid(), 9)")
    assert (status, err.count("\n")) == (2, 1)
    assert os.listdir() == []


@pytest.mark.skipif(sys.platform != "linux", reason="the system does not tell the child")
def test_a_parent_that_is_killed_takes_the_worker_with_it():
    process = start("print(os.getpid(), flush=True); time.sleep(60)")
    worker = int(process.stdout.readline())
    assert alive(worker)
    process.kill()
    process.communicate()
    for _ in range(100):
        if not alive(worker):
            return
        time.sleep(0.05)
    pytest.fail("it goes on")


def test_a_pipe_that_nobody_reads_ends_the_work_quietly():
    process = start("for _ in range(100_000): print('a line')")
    assert process.stdout.readline() == "a line\n"
    process.stdout.close()
    assert process.stderr.read() == ""
    process.stderr.close()
    assert process.wait(20) == 141


NOISE = "os.write(2, b'library\\n'); print('command', file=sys.stderr)"


@pytest.mark.parametrize(("more", "said"), [([], "command\n"), (["--verbose"], "library\ncommand\n")])
def test_what_libraries_print_is_kept_for_verbose(more, said):
    assert run(NOISE, *more) == (0, "", said)


def test_names_that_are_no_text_can_be_printed():
    work = "name = os.fsdecode(bytes([0xff])); print(name); print(name, file=sys.stderr)"
    assert run(work) == (0, "\\udcff\n", "\\udcff\n")
