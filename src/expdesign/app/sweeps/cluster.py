"""The engine that runs on a Dask cluster (extra `cluster`)."""

import queue
import threading
from collections.abc import Iterator, Sequence
from typing import Any

from expdesign.app.sweeps.engine import Engine, Work, WorkersError
from expdesign.app.sweeps.runs import computed_by
from expdesign.errors import ArgumentError

_LOST = "The runs that are finished are kept; start the cluster again and give the same command."
_POLL = 1.0
"""s between looks at whether the scheduler is still there."""
_ONE_AT_A_TIME = threading.Lock()


class Cluster(Engine):
    """The workers of a Dask scheduler. A task of a worker that ends is done by another one (Dask sees to that).

    Args:
        address: of the scheduler, e.g. `tcp://192.168.0.5:8786`.

    Raises:
        InputError: Dask is not installed, nothing answers there, or a worker has other code or other libraries.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client  # noqa: PLC0415 (an extra)
        except ImportError:
            remedy = "Install it: pip install 'expdesign[cluster]'."
            raise ArgumentError("Dask is not installed", argument="cluster", remedy=remedy) from None
        try:
            self._client = Client(address, timeout=10, set_as_default=False)
        except (OSError, ValueError) as error:
            remedy = "Start a scheduler (`dask scheduler`) and workers (`dask worker ADDRESS --nthreads 1`)."
            raise ArgumentError(
                f"no scheduler answers at {address} ({error})", argument="cluster", remedy=remedy
            ) from None
        own = computed_by()
        for worker, theirs in self._client.run(computed_by).items():
            differing = [name for name in own if theirs.get(name) != own[name]]
            if differing:
                self._client.close()
                named = ", ".join(
                    f"{name} {theirs.get(name, 'not known')} instead of {own[name]}" for name in differing
                )
                remedy = "Install the same expdesign and the same versions of its libraries everywhere."
                raise ArgumentError(f"worker {worker} computes with {named}", argument="cluster", remedy=remedy)

    def close(self) -> None:
        self._client.close(timeout=5)

    def execute(self, work: Work, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        from distributed.scheduler import KilledWorker  # noqa: PLC0415 (an extra)

        done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        running: dict[str, tuple[int, Any]] = {}
        try:
            for index, task in enumerate(tasks):
                future = self._client.submit(alone, work, task, pure=False)
                running[future.key] = (index, future)
                future.add_done_callback(done.put)
            while running:
                try:
                    future = done.get(timeout=_POLL)
                except queue.Empty:
                    if self._client.status not in ("running", "connecting"):
                        raise WorkersError("the connection to the scheduler was lost", remedy=_LOST) from None
                    continue
                if future.status == "error" and isinstance(future.exception(), KilledWorker):
                    what = "workers ended several times while they did the same work"
                    raise WorkersError(what, remedy="Is there enough memory? Use fewer workers.")
                if future.status in ("cancelled", "lost"):
                    raise WorkersError("the connection to the scheduler was lost", remedy=_LOST)
                index, _ = running.pop(future.key)
                yield index, future.result()
        finally:
            self._client.cancel([future for _, future in running.values()])


def alone(work: Work, task: Any) -> Any:
    """`work(task)`, and nothing else in this process meanwhile: expressions must not be built in several threads."""
    with _ONE_AT_A_TIME:
        return work(task)
