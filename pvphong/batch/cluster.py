"""Processes that do the work: those of a Dask cluster somewhere, or of a local one for as long as needed."""

from __future__ import annotations

import logging
import socket
from asyncio import CancelledError
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

from pvphong.base import check, threads

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")

_SECONDS = 5
"""For a scheduler to answer."""

_PACKAGES = ("pvphong", "numpy", "pyvista", "vtk")
"""What colours and files depend on: they are to be the same everywhere."""

_KILLED = "the process that read it was killed each time: its reader crashes, or it takes more memory than a worker has"
_GONE = "the scheduler is gone; what is finished stays, and the same call goes on with the rest"
_ADDRESS = "a distributed.Client, or the address of a Dask scheduler that answers, as tcp://host:8786"


@contextmanager
def connected(client: Any, workers: int | None) -> Iterator[Cluster]:
    """The workers of a cluster: of a client, at an address, or of a local cluster that lasts as long as this.

    Raises
    ------
    ValueError
        If there is no Dask, no scheduler or no worker, or if they run other versions than this process.
    """
    with ExitStack() as held:
        try:
            found = _connected(client, workers, held)
        except ImportError as error:
            remedy = 'pip install "pvphong[dask]" installs it.'
            check.refuse("client", f"no Dask here ({error})", "one where Dask is installed", remedy)
        _refuse_versions(found)
        yield Cluster(found)


def _connected(client: Any, workers: int | None, held: ExitStack) -> Client:
    from distributed import Client

    if client is None:
        return _local(workers, held)
    if workers is not None:
        check.refuse("workers", workers, "left out beside a client, whose cluster has its own")
    if not isinstance(client, str):
        return client if isinstance(client, Client) else check.refuse("client", client, _ADDRESS)
    try:
        _knock(client)
        return held.enter_context(Client(client, timeout=_SECONDS, set_as_default=False))
    except (OSError, ValueError) as error:
        check.refuse("client", client, _ADDRESS, f"{error}.")


def _knock(address: str) -> None:
    """Raise an error where nobody listens: Dask would try for seconds, and tell of each try."""
    scheme, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if scheme in ("", "tcp", "tls"):
        if not port.isdecimal():
            raise ValueError("It names no port")
        with socket.create_connection((host.strip("[]"), int(port)), _SECONDS):
            pass


def _local(workers: int | None, held: ExitStack) -> Client:
    """Processes with one thread each; a piece at a time, so that none is blamed for another's end."""
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
            silence_logs=logging.CRITICAL,  # what becomes of a piece is in the batch
            env={"VTK_SMP_MAX_THREADS": "1"},
        )
    except RuntimeError as error:
        remedy = 'In a script, call it below `if __name__ == "__main__":`, for each process reads the script.'
        check.refuse("workers", f"{count} that cannot be started ({error})", "processes of this machine", remedy)
    held.enter_context(cluster)
    return held.enter_context(Client(cluster, set_as_default=False))


def _refuse_versions(client: Client) -> None:
    """By Dask's own check, for what colours depend on; of its own packages Dask warns when one connects."""
    found = client.get_versions(packages=list(_PACKAGES))
    if not found["workers"]:
        check.refuse("client", "a cluster without workers", "one that has some", "Start workers: dask worker ADDRESS.")
    here = found["client"]["packages"]
    for address, there in found["workers"].items():
        for package in _PACKAGES:
            got = there["packages"].get(package)
            if got != here.get(package):
                told = f"{package} {got or 'missing'} at {address}"
                remedy = "Install the same version there."
                check.refuse("client", told, f"one whose workers have {package} {here.get(package)} as here", remedy)


class Cluster:
    """The workers of a cluster."""

    def __init__(self, client: Client) -> None:
        self._client = client

    def begin(self, work: Callable[..., Any], *arguments: Any) -> Any:
        """A task; its arguments may be others, which then go from worker to worker."""
        return self._client.submit(work, *arguments, pure=False)

    def ended(self, tasks: Iterable[Any]) -> Iterator[Any]:
        """Tasks as they end; their values stay with the workers."""
        from distributed import as_completed

        return iter(as_completed(list(tasks), loop=self._client.loop))

    def done(self, tasks: Mapping[Any, Item], failed: Callable[[str], Any]) -> Iterator[tuple[Item, Any]]:
        """What tasks stand for, and the value of each as it ends; else what `failed` makes of the reason."""
        for task in self.ended(tasks):
            yield tasks[task], self._value(task, failed)

    @staticmethod
    def _value(task: Any, failed: Callable[[str], Any]) -> Any:
        why = trouble(task)
        try:
            return failed(why) if why else task.result()
        except (OSError, CancelledError):  # the scheduler went in between
            return failed(_GONE)


def trouble(task: Any) -> str:
    """Why a task that has ended has no value; "" if it has one."""
    from distributed import KilledWorker

    if task.status == "finished":
        return ""
    if task.status != "error":
        return _GONE
    error = task.exception()
    return _KILLED if isinstance(error, KilledWorker) else " ".join(str(error).split()) or type(error).__name__
