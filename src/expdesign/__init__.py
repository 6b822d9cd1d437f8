"""Plan and evaluate the calibration of robots that carry loads.

The package reads like the command line (`docs/api.ipynb`):

    import expdesign as xd

    run = xd.run("configs/hexapod-h1.yaml")     # the Pareto front, as frames and typed objects
    run.plan                                    # what to measure
    run.save("results/mine")                    # the files of `expdesign run`

A function lies in the file of its name in `expdesign.api`, and is imported when it is first used.
"""

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers and editors; at run time `__getattr__` finds them by their place
    from expdesign.api.compare import compare as compare
    from expdesign.api.compensate import compensate as compensate
    from expdesign.api.correct import correct as correct
    from expdesign.api.diagnose import diagnose as diagnose
    from expdesign.api.evaluate import evaluate as evaluate
    from expdesign.api.identify import identify as identify
    from expdesign.api.load import load as load
    from expdesign.api.montecarlo import montecarlo as montecarlo
    from expdesign.api.predict import predict as predict
    from expdesign.api.run import run as run
    from expdesign.api.simulate import simulate as simulate
    from expdesign.api.sweep import sweep as sweep
    from expdesign.api.verify import verify as verify

__version__ = "0.1.0"


def _functions() -> list[str]:
    path = importlib.import_module("expdesign.api").__path__
    return [info.name for info in pkgutil.iter_modules(path) if info.name != "inputs"]


def __getattr__(name: str) -> Any:
    if name.startswith("_") or name not in _functions():
        raise AttributeError(f"module `expdesign` has no attribute `{name}`")
    function = getattr(importlib.import_module(f"expdesign.api.{name}"), name)
    globals()[name] = function
    return function


def __dir__() -> list[str]:
    return sorted({*globals(), *_functions()})
