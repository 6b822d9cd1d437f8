"""Tasks that do not need each other, done by executors of `concurrent.futures`.

A sweep, a comparison and repeated experiments apply a function to tasks and take each result as it arrives. Where that
happens is the executor's business: processes of this machine, a Dask cluster, or whatever a user brings. What is added
here is what can go wrong: work whose process ends is given to a new executor, and what is left is ended with the
iteration, however that ends.
"""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, as_completed
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing.connection import wait as wait_for
from typing import Any, TypeVar

from expdesign.assurance.comparison.contenders import Each
from expdesign.errors import ArgumentError, ExpdesignError
from expdesign.planning.problem import DesignProblem
from expdesign.processors import processors

R = TypeVar("R")
Executors = Callable[[], Executor]
"""Makes the executor of tasks, and another one where processes ended with their work."""

SINGLE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
MOST_ATTEMPTS = 3
"""Times in a row that processes may end without a result before their work is given up."""
_ONE_AT_A_TIME = threading.Lock()


class WorkersError(ExpdesignError):
    """The workers are gone, or end whenever they are given some task."""


def results(
    work: Callable[[Any], R], tasks: Sequence[Any], executors: Executors | None = None
) -> Iterator[tuple[int, R]]:
    """Index and result of every task, in the order in which they are done.

    What `work` raises is raised here. Closing the iterator ends what is still running.

    Args:
        work: a function that can be sent to another process.
        tasks: its arguments.
        executors: makes what does them; one after another in this process if left out.

    Raises:
        WorkersError: tasks are left and there is nothing that could do them.
    """
    if executors is None:
        yield from ((index, work(task)) for index, task in enumerate(tasks))
        return
    waiting, ended = dict(enumerate(tasks)), 0
    while waiting:
        with executors() as executor:
            try:
                running = {executor.submit(alone, work, task): index for index, task in waiting.items()}
                for future in as_completed(running):
                    result = _result(future)
                    del waiting[running[future]]
                    ended = 0
                    yield running[future], result
            except BrokenExecutor:  # what was running or waiting is lost with it
                ended += 1
            except BaseException:
                with suppress(Exception):  # a cluster whose scheduler is gone cannot be told to stop
                    executor.shutdown(wait=False, cancel_futures=True)
                raise
        if ended == MOST_ATTEMPTS:
            what = f"worker processes ended {MOST_ATTEMPTS} times while they did the same work"
            raise WorkersError(what, remedy="Is there enough memory? Use fewer workers.")


def each_of(problem: DesignProblem, executors: Executors | None) -> Each:
    """Parts of the work on one problem by executors: index and result of `work(problem, *arguments)`."""
    return lambda work, arguments: results(_part, [(work, problem, one) for one in arguments], executors)


def _part(task: tuple[Callable[..., R], DesignProblem, tuple[Any, ...]]) -> R:
    work, problem, arguments = task
    return work(problem, *arguments)


def _result(future: "Future[R]") -> R:
    try:
        return future.result()
    except CancelledError:
        remedy = "The runs that are finished are kept; start the cluster again and give the same command."
        raise WorkersError("the connection to the scheduler was lost", remedy=remedy) from None
    except Exception as error:
        distributed = sys.modules.get("distributed")
        if distributed is None or not isinstance(error, distributed.KilledWorker):
            raise
        what = "workers ended several times while they did the same work"
        raise WorkersError(what, remedy="Is there enough memory? Use fewer workers.") from None


def alone(work: Callable[[Any], R], task: Any) -> R:
    """`work(task)`, and nothing else in this process meanwhile: expressions must not be built in several threads."""
    with _ONE_AT_A_TIME:
        return work(task)


@contextmanager
def executors_of(workers: int | None, cluster: str | None, default: int | None = None) -> Iterator[Executors | None]:
    """The executors of the options `--workers` and `--cluster`; None for this process.

    Args:
        workers: number of processes.
        cluster: address of a Dask scheduler.
        default: number of processes where neither is given; as many as there are processors to use if left out.

    Raises:
        ArgumentError: both are given, or one is wrong.
    """
    if cluster is not None and workers is not None:
        what, remedy = "only one of argument `workers` and argument `cluster` can be given", "Workers of a cluster"
        remedy += " are started with it (`dask worker ADDRESS --nthreads 1`)."
        raise ArgumentError(what, argument="workers", remedy=remedy)
    if workers is not None and workers < 1:
        raise ArgumentError(f"{workers} is not a number of processes", argument="workers", remedy="Use at least 1.")
    if cluster is not None:
        with _client(cluster) as client:
            yield partial(client.get_executor, pure=False)
    else:
        count = workers or default or processors()
        # On the threads of linear algebra the last bits may depend: a process that is started has one.
        os.environ.update(dict.fromkeys(SINGLE_THREAD, "1"))
        yield None if count == 1 else partial(Processes, count)


def _client(address: str) -> Any:
    try:
        from distributed import Client  # noqa: PLC0415 (an extra)
    except ImportError:
        remedy = "Install it: pip install 'expdesign[cluster]'."
        raise ArgumentError("Dask is not installed", argument="cluster", remedy=remedy) from None
    try:
        return Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        remedy = "Start a scheduler (`dask scheduler`) and workers (`dask worker ADDRESS --nthreads 1`)."
        what = f"no scheduler answers at {address} ({error})"
        raise ArgumentError(what, argument="cluster", remedy=remedy) from None


class Processes(ProcessPoolExecutor):
    """Processes of this machine, which end with the work, however that ends.

    Args:
        workers: how many.
    """

    def __init__(self, workers: int) -> None:
        self._before = set(multiprocessing.active_children())
        super().__init__(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_settle)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """As the base class; what is running is ended where it is not waited for."""
        if not wait:
            for process in set(multiprocessing.active_children()) - self._before:
                process.terminate()
        super().shutdown(wait=True, cancel_futures=cancel_futures)


def _settle() -> None:
    """In a new worker: Ctrl-C is for the process that started it, and without that process it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)
