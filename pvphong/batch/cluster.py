"""Worker processes of a Dask cluster: a given cluster, or a local one for the duration of a call."""

from __future__ import annotations

import logging
import socket
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from pvphong.base import check, threads
from pvphong.batch.worker import Result, reason_of

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")

_SECONDS = 5
"""Timeout for the connection to a scheduler."""

_PACKAGES = ("pvphong", "numpy", "pyvista", "vtk")
"""Packages that colours and files depend on; their versions must agree on all workers."""

_KILLED = "all workers that read it were killed: the reader crashes, or the file needs more memory than a worker has"
_GONE = "the connection to the scheduler was lost; finished files are kept; repeat the call to light the others"
_ADDRESS = "a distributed.Client, or the address of a running Dask scheduler such as tcp://host:8786"


class _Task:
    """Finished task of a `Here` client, with its value. Tasks are compared by identity, so that they can be keys."""

    def __init__(self, value: Any) -> None:
        self.value = value


class Here:
    """Client that runs tasks in this process, one after the other. It lights a single file if Dask is not installed."""

    def submit(self, work: Callable[..., Any], *given: Any, pure: bool) -> Any:  # noqa: ARG002 as of Dask's
        """Call `work` with the arguments `given` at once, and return a finished task.

        A task among the arguments is replaced by its value. If the call raises, the value of the new task is a `Result`
        with the reason. `pure` is ignored; it is a parameter of Dask's clients.
        """
        try:
            return _Task(work(*(each.value if isinstance(each, _Task) else each for each in given)))
        except Exception as error:  # any error, as in a Dask task
            return _Task(Result(reason=reason_of(error)))


@contextmanager
def connected(client: Any, workers: int | None, pieces: int) -> Iterator[Client | Here]:
    """Yield a client of a Dask cluster for the duration of the block.

    Parameters
    ----------
    client : Client, str or None
        A client is yielded unchanged. For the address of a scheduler, a client of this scheduler is yielded. None
        starts a local cluster that ends with the block.
    workers : int or None
        Number of processes of a local cluster; None for the number of processors.
    pieces : int
        Number of pieces to light. If Dask is not installed, a single piece is lit in this process.

    Raises
    ------
    ValueError
        If Dask is not installed, no scheduler or worker is found, or workers have other versions than this process.
    """
    try:
        from distributed import Client
    except ImportError as error:
        if pieces == 1 and client is None and workers is None:
            yield Here()
            return
        remedy = "Run: pip install dask distributed. Without Dask, light each file by its own call."
        check.refuse("client", f"no Dask ({error})", "a client of Dask, so Dask must be installed", remedy)
    if client is not None and workers is not None:
        check.refuse("workers", workers, "omitted with a client, because its cluster has workers")
    if client is not None and not isinstance(client, (str, Client)):
        check.refuse("client", client, _ADDRESS)
    with ExitStack() as held:
        if client is None:
            client = _local(workers, held)
        elif isinstance(client, str):
            try:
                _refuse_silent(client)
                client = held.enter_context(Client(client, timeout=_SECONDS, set_as_default=False))
            except (OSError, ValueError) as error:
                check.refuse("client", client, _ADDRESS, f"{error}.")
        _refuse_other_versions(client)
        yield client


def _refuse_silent(address: str) -> None:
    """Raise an error if no scheduler answers at an address, or a TCP address has no port.

    Without this check, Dask would retry for seconds and print each attempt. Addresses with a protocol other than tcp
    and tls are not checked.
    """
    scheme, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme in ("", "tcp", "tls"):
        if not port.isdecimal():
            raise ValueError("The address has no port")
        with socket.create_connection((host.strip("[]"), int(port)), _SECONDS):
            pass


def _local(workers: int | None, held: ExitStack) -> Client:
    """Start a local cluster with one thread in each process, and return its client.

    A process gets one piece at a time, so that a crash can be attributed to its piece.

    Parameters
    ----------
    workers : int or None
        Number of processes; None for the number of processors.
    held : ExitStack
        Ends the client and the cluster when it is closed.
    """
    import dask
    from distributed import Client, LocalCluster

    count = threads.count() if workers is None else int(check.number("workers", workers, at_least=1.0))
    held.enter_context(dask.config.set({"distributed.scheduler.worker-saturation": 1.0}))
    try:
        cluster = LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            dashboard_address=":0",
            scheduler_kwargs={"dashboard": False},
            silence_logs=logging.CRITICAL,  # the batch reports failures
            env={"VTK_SMP_MAX_THREADS": "1"},
        )
    except RuntimeError as error:
        remedy = 'In a script, call it below `if __name__ == "__main__":`, because each process imports the script.'
        check.refuse(
            "workers", f"{count}, which did not start ({error})", "a number of processes that can be started", remedy
        )
    held.enter_context(cluster)
    return held.enter_context(Client(cluster, set_as_default=False))


def _refuse_other_versions(client: Client) -> None:
    """Raise ``ValueError`` if a cluster has no workers, or a worker has other versions of packages than this process.

    Only the versions of `_PACKAGES` are compared. Dask itself warns about different versions of its own packages.
    """
    found = client.get_versions(packages=list(_PACKAGES))
    if not found["workers"]:
        check.refuse(
            "client", "a cluster without workers", "a cluster with workers", "Start workers: dask worker ADDRESS."
        )
    here = found["client"]["packages"]
    for address, there in found["workers"].items():
        for package in _PACKAGES:
            got = there["packages"].get(package)
            if got != here.get(package):
                allowed = f"a cluster whose workers have {package} {here.get(package)}, like this process"
                remedy = "Install the same version on the workers."
                check.refuse("client", f"{package} {got or 'missing'} at {address}", allowed, remedy)


def ended(client: Client | Here, tasks: Mapping[Any, Item], *, fetches: bool = True) -> Iterator[tuple[Item, Any]]:
    """Yield the item and the value of each task, in the order in which tasks end.

    An item is any object that belongs to a task, such as the piece that the task lights.

    Parameters
    ----------
    client : Client or Here
        Client that runs the tasks.
    tasks : mapping
        Task → item.
    fetches : bool, default True
        True to yield the tasks' values. False to leave the values on the workers, and yield the tasks themselves.

    Yields
    ------
    item, value
        The value is a `Result` with the reason if the task failed.
    """
    if isinstance(client, Here):
        for task, item in tasks.items():
            yield item, task.value if fetches or isinstance(task.value, Result) else task
        return
    from distributed import KilledWorker, as_completed

    for task in as_completed(list(tasks), loop=client.loop):
        value: Any = Result(reason=_GONE)
        if task.status == "error":
            error = task.exception()
            value = Result(reason=_KILLED if isinstance(error, KilledWorker) else reason_of(error))
        elif task.status == "finished":
            with suppress(OSError, CancelledError):  # the scheduler may end meanwhile
                value = task.result() if fetches else task
        yield tasks[task], value
