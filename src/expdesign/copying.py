"""Copies and pickles of objects that hold CasADi expressions, whose symbols have to stay the same ones throughout."""

import pickle
from contextvars import ContextVar
from typing import Any

import casadi as ca

_INSIDE = ContextVar("_INSIDE", default=False)
"""Whether the object is part of one that is being pickled, in whose context its symbols are."""


class Copied:
    """An object whose copies and pickles hold copies of its expressions, with symbols of their own."""

    def __reduce_ex__(self, protocol: Any, /) -> Any:
        if _INSIDE.get():
            return super().__reduce_ex__(protocol)
        mark = _INSIDE.set(True)
        try:
            with ca.global_pickle_context():
                state = pickle.dumps(self.__dict__, protocol)
        finally:
            _INSIDE.reset(mark)
        return _restored, (type(self), state)


def _restored(kind: type[Copied], state: bytes) -> Copied:
    with ca.global_unpickle_context():
        content = pickle.loads(state)
    found: Copied = object.__new__(kind)
    found.__dict__.update(content)
    return found
