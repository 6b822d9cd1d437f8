"""A second process that does every other part of a work on a design problem.

It is a copy of the process that asks (`fork`), so that it has the problem with its symbolic expressions, which cannot
be sent; only what differs from part to part is. Where there is no second processor, or no `fork`, the parts are done
one after another, with the same results.
"""

import multiprocessing
import pickle
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from typing import Any, Self, TypeVar

from expdesign.design.parts import Done, Parts, one_after_another, unnoticed
from expdesign.design.problem import DesignProblem
from expdesign.processors import processors

R = TypeVar("R")
_LOST = (EOFError, BrokenPipeError, ConnectionResetError)
"""What a pipe raises whose other end is gone."""


def second_process_helps() -> bool:
    """Whether there is a second processor and this process can copy itself safely, which macOS does not promise."""
    return processors() > 1 and "fork" in multiprocessing.get_all_start_methods() and sys.platform != "darwin"


class TwoProcesses:
    """An executor: what does the parts of works on one problem after the other. A context that ends its copies."""

    def __init__(self) -> None:
        self._present: SecondProcess | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """End the copy that there is."""
        if self._present is not None:
            self._present.close()

    def __call__(self, problem: DesignProblem) -> Parts:
        """Does the parts of works on a problem from now on, and no longer of the one before."""
        self.close()
        self._present = SecondProcess(problem)
        return self._present


class SecondProcess:
    """Does the first, third, ... part of a work here and the others in a copy of this process.

    Where the copy is lost, its parts are done here.

    Args:
        problem: the design problem.
    """

    def __init__(self, problem: DesignProblem) -> None:
        self._problem = problem
        context = multiprocessing.get_context("fork")
        here, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(problem, there, here), daemon=True)
        with warnings.catch_warnings():
            # Threads that show progress or serve a page hold no lock that the copy needs.
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process.start()
        there.close()
        self._copy: Connection | None = here

    def close(self) -> None:
        """End the copy; what follows is done here."""
        if self._copy is not None:
            self._copy.close()
            self._copy = None
            # In the middle of a part it would not notice before the end of that.
            self._process.terminate()
            self._process.join()

    def __call__(self, work: Callable[..., R], arguments: Sequence[tuple[Any, ...]], done: Done = unnoticed) -> list[R]:
        """`work(problem, *each)` of all arguments, in their order (see `Parts`); `work` is a function of a module."""
        theirs = range(1, len(arguments), 2)
        if self._copy is None or not theirs:
            return one_after_another(self._problem)(work, arguments, done)
        results: dict[int, R] = {}

        def do_here(indices: range) -> None:
            for index in indices:
                results[index] = work(self._problem, *arguments[index])
                done(index)

        try:
            asked = self._asked(work, [arguments[index] for index in theirs])
            do_here(range(0, len(arguments), 2))
            answer = self._answer() if asked else None
        except BaseException:
            # An answer that nobody takes would be taken for that of the next work.
            self.close()
            raise
        if isinstance(answer, BaseException):
            raise answer
        if answer is None:
            self.close()
            do_here(theirs)
        else:
            for index, result in zip(theirs, answer, strict=True):
                results[index] = result
                done(index)
        return [results[index] for index in range(len(arguments))]

    def _asked(self, work: Callable[..., R], arguments: list[tuple[Any, ...]]) -> bool:
        """Whether there is still a copy that could be asked."""
        assert self._copy is not None
        try:
            self._copy.send((work, arguments))
        except _LOST:
            return False
        return True

    def _answer(self) -> Any:
        """Results of the copy, what it raised, or None where it is lost."""
        assert self._copy is not None
        try:
            return self._copy.recv()
        except _LOST:
            return None


def _serve(problem: DesignProblem, there: Connection, here: Connection) -> None:
    """In the copy: do what is sent until nothing more can come."""
    # The copy holds the other end too, without which it would wait for ever.
    here.close()
    # Ctrl-C is for the process that was copied.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            work, arguments = there.recv()
        except EOFError:
            return
        answer: Any
        try:
            answer = [work(problem, *each) for each in arguments]
        except Exception as error:
            answer = _sendable(error)
        try:
            there.send(answer)
        except _LOST:
            return


def _sendable(error: Exception) -> Exception:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error
