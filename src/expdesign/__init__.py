"""Plan and evaluate the calibration of robots that carry loads.

The package reads like the command line (`docs/api.ipynb`):

    import expdesign as xd

    run = xd.run("configs/hexapod-h1.yaml")     # the Pareto front, as frames and typed objects
    run.plan                                    # what to measure
    run.save("results/mine")                    # the files of `expdesign run`

A function lies in the file of its name in `expdesign.api`, and is imported when it is first used. It has the name of
its command, except `plan_next`, because `next` is a builtin. Results are typed: `from expdesign import Run`.
"""

import importlib
import pkgutil
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers and editors; at run time `__getattr__` finds them by their place
    from expdesign.api.check import Checked as Checked
    from expdesign.api.check import CheckedModel as CheckedModel
    from expdesign.api.check import CheckedProblem as CheckedProblem
    from expdesign.api.check import CheckedRecordings as CheckedRecordings
    from expdesign.api.check import CheckedRobot as CheckedRobot
    from expdesign.api.check import CheckedSweep as CheckedSweep
    from expdesign.api.check import check as check
    from expdesign.api.compare import Comparison as Comparison
    from expdesign.api.compare import compare as compare
    from expdesign.api.compensate import Commands as Commands
    from expdesign.api.compensate import compensate as compensate
    from expdesign.api.correct import Corrected as Corrected
    from expdesign.api.correct import correct as correct
    from expdesign.api.diagnose import Diagnosed as Diagnosed
    from expdesign.api.diagnose import diagnose as diagnose
    from expdesign.api.evaluate import Evaluation as Evaluation
    from expdesign.api.evaluate import evaluate as evaluate
    from expdesign.api.identify import Identified as Identified
    from expdesign.api.identify import identify as identify
    from expdesign.api.inputs import RobotFile as RobotFile
    from expdesign.api.load import load as load
    from expdesign.api.montecarlo import MonteCarlo as MonteCarlo
    from expdesign.api.montecarlo import montecarlo as montecarlo
    from expdesign.api.plan_next import PlannedNext as PlannedNext
    from expdesign.api.plan_next import plan_next as plan_next
    from expdesign.api.predict import Predicted as Predicted
    from expdesign.api.predict import predict as predict
    from expdesign.api.register import Registered as Registered
    from expdesign.api.register import register as register
    from expdesign.api.run import Run as Run
    from expdesign.api.run import run as run
    from expdesign.api.schema import schema as schema
    from expdesign.api.sheet import LaboratorySheet as LaboratorySheet
    from expdesign.api.sheet import sheet as sheet
    from expdesign.api.simulate import Simulated as Simulated
    from expdesign.api.simulate import simulate as simulate
    from expdesign.api.sweep import Sweep as Sweep
    from expdesign.api.sweep import sweep as sweep
    from expdesign.api.table import Corrections as Corrections
    from expdesign.api.table import table as table
    from expdesign.api.verify import Verified as Verified
    from expdesign.api.verify import verify as verify
    from expdesign.design.problem import DesignProblem as DesignProblem
    from expdesign.errors import ExpdesignError as ExpdesignError
    from expdesign.errors import InputError as InputError
    from expdesign.models.model_file import Model as Model
    from expdesign.recordings.recordings import Recordings as Recordings

__version__ = "0.1.0"

_TYPES = {
    "Checked": "api.check",
    "CheckedModel": "api.check",
    "CheckedProblem": "api.check",
    "CheckedRecordings": "api.check",
    "CheckedRobot": "api.check",
    "CheckedSweep": "api.check",
    "Commands": "api.compensate",
    "Comparison": "api.compare",
    "Corrections": "api.table",
    "Corrected": "api.correct",
    "DesignProblem": "design.problem",
    "Diagnosed": "api.diagnose",
    "Evaluation": "api.evaluate",
    "ExpdesignError": "errors",
    "Identified": "api.identify",
    "InputError": "errors",
    "LaboratorySheet": "api.sheet",
    "Model": "models.model_file",
    "MonteCarlo": "api.montecarlo",
    "PlannedNext": "api.plan_next",
    "Predicted": "api.predict",
    "Recordings": "recordings.recordings",
    "Registered": "api.register",
    "RobotFile": "api.inputs",
    "Run": "api.run",
    "Simulated": "api.simulate",
    "Sweep": "api.sweep",
    "Verified": "api.verify",
}


def _functions() -> list[str]:
    path = importlib.import_module("expdesign.api").__path__
    return [info.name for info in pkgutil.iter_modules(path) if info.name not in ("inputs", "outputs")]


def __getattr__(name: str) -> Any:
    if name in _TYPES:
        found = getattr(importlib.import_module(f"expdesign.{_TYPES[name]}"), name)
    elif not name.startswith("_") and name in _functions():
        found = getattr(importlib.import_module(f"expdesign.api.{name}"), name)
    else:
        raise AttributeError(f"module `expdesign` has no attribute `{name}`")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *_functions(), *_TYPES})
