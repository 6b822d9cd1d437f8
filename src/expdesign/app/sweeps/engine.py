"""An engine executes independent tasks, whatever it runs on.

A sweep, a comparison and repeated experiments need one thing of a machine, or of many: apply a function to tasks, and
return each result as it arrives. One process does that in two lines. Several processes and a cluster add only what can
go wrong there: the task of a worker that is killed is repeated by another one; if the command itself is killed, results
that had not been returned are lost. Runs, files and progress are unknown here, so that none of them can depend on where
the tasks run.

The parts of a work on a design problem, done by an engine.

A problem holds symbolic expressions, which cannot be sent. It travels as its resolved configuration, from which a
worker makes the same problem, once for all parts that it is given.
"""

import copy
import json
import multiprocessing
import os
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import lru_cache
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from typing import Any, Self, TypeVar

from expdesign.errors import ArgumentError, ExpdesignError
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.parts import Done, Parts, unnoticed
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.processors import processors

Work = Callable[[Any], Any]
"""A function of a module, which can be sent to another process by its name."""

SINGLE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
MOST_ATTEMPTS = 3
"""Times in a row that processes may end without a result before their work is given up."""


class WorkersError(ExpdesignError):
    """The workers are gone, or end whenever they are given some task."""


class Engine(ABC):
    """Executes tasks; as a context it is closed when the block ends."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Give back what is held beyond single tasks (the connection to a cluster)."""
        return None

    @abstractmethod
    def execute(self, work: Work, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """Index and result of every task, in the order in which they are done.

        What `work` raises is raised here. Closing the iterator ends what is still running.

        Raises:
            WorkersError: tasks are left and there is nothing that could do them.
        """


class Serial(Engine):
    """One task after another in this process."""

    def execute(self, work: Work, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        for index, task in enumerate(tasks):
            yield index, work(task)


class Processes(Engine):
    """Processes of this machine, one thread of linear algebra each.

    Args:
        workers: how many.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers

    def execute(self, work: Work, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        waiting, ended = dict(enumerate(tasks)), 0
        while waiting:
            with _single_threaded(), _pool(min(self.workers, len(waiting))) as pool:
                running = {pool.submit(work, task): index for index, task in waiting.items()}
                try:
                    for future in as_completed(running):
                        result = future.result()
                        del waiting[running[future]]
                        ended = 0
                        yield running[future], result
                except BrokenProcessPool:  # what was running or waiting is lost with it
                    ended += 1
            if ended == MOST_ATTEMPTS:
                what = f"worker processes ended {MOST_ATTEMPTS} times while they did the same work"
                raise WorkersError(what, remedy="Is there enough memory? Use fewer workers.")


def engine_of(workers: int | None, cluster: str | None, default: int | None = None) -> Engine:
    """The engine of the options `--workers` and `--cluster`, to be used as a context.

    Args:
        workers: number of processes.
        cluster: address of a Dask scheduler.
        default: number of processes where neither is given; as many as there are processors to use if left out.

    Raises:
        ArgumentError: both are given, or one is wrong.
    """
    if cluster is not None:
        if workers is not None:
            what, remedy = "only one of argument `workers` and argument `cluster` can be given", "Workers of a cluster"
            remedy += " are started with it (`dask worker ADDRESS --nthreads 1`)."
            raise ArgumentError(what, argument="workers", remedy=remedy)
        from expdesign.app.sweeps.cluster import Cluster  # noqa: PLC0415 (an extra)

        return Cluster(cluster)
    if workers is not None and workers < 1:
        raise ArgumentError(f"{workers} is not a number of processes", argument="workers", remedy="Use at least 1.")
    count = workers or default or processors()
    return Serial() if count == 1 else Processes(count)


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Fresh processes, which are ended with the block however it is left."""
    before = set(multiprocessing.active_children())
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_settle)
    try:
        yield pool
    except BaseException:
        # Waiting for what is running would take as long as it takes.
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Processes that start inside the block have one thread of linear algebra, on which the last bits may depend."""
    before = {name: os.environ.get(name) for name in SINGLE_THREAD}
    os.environ.update(dict.fromkeys(SINGLE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _settle() -> None:
    """In a new worker: Ctrl-C is for the process that started it, and without that process it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()


def _end_with(sentinel: int) -> None:
    wait_for([sentinel])
    os._exit(1)


R = TypeVar("R")


def by_engine(problem: DesignProblem, engine: Engine) -> Parts:
    """Does the parts of a work on `problem`, which came from a configuration, by an engine."""
    travelling = json.dumps([problem.source, _travelling(problem)])

    def execute(work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        results: dict[int, R] = {}
        for index, result in engine.execute(part, [(work, travelling, each) for each in arguments]):
            results[index] = result
            done(index)
        return [results[index] for index in range(len(arguments))]

    return execute


def part(task: tuple[Callable[..., R], str, tuple[Any, ...]]) -> R:
    """One part, in a worker."""
    work, travelling, arguments = task
    return work(_arrived(travelling), *arguments)


@lru_cache(maxsize=8)
def _arrived(travelling: str) -> DesignProblem:
    source, config = json.loads(travelling)
    return problem_from_document(YamlDocument(source, Path(), config))


def _travelling(problem: DesignProblem) -> dict[str, Any]:
    """The resolved configuration, with the place of a URDF file written out."""
    config = copy.deepcopy(problem.config)
    folder = Path(problem.robot_file or problem.source).parent
    for robot in (config["robot"], config["robot"].get("robot")):
        if isinstance(robot, dict) and isinstance(robot.get("urdf"), str):
            robot["urdf"] = str((folder / robot["urdf"]).resolve())
    return config
