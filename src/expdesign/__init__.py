"""Plan and evaluate the calibration of robots that carry loads.

The package reads like the command line (`docs/api.ipynb`):

    import expdesign as xd

    run = xd.run("configs/hexapod-h1.yaml")     # the Pareto front, as frames and typed objects
    run.plan                                    # what to measure
    run.save("results/mine")                    # the files of `expdesign run`

A function is imported from the file of its name when it is first used. It has the name of its command, except
`plan_next`, because `next` is a builtin. Results are typed. Robots and configurations can be made as objects
(`xd.Hexapod`, `xd.Configuration`).
"""

import functools as _functools
import importlib as _importlib
import pathlib as _pathlib
import typing as _typing

if _typing.TYPE_CHECKING:  # for type checkers and editors; at run time `__getattr__` finds them by their place
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
    from expdesign.api.extend import extend as extend
    from expdesign.api.identify import Identified as Identified
    from expdesign.api.identify import identify as identify
    from expdesign.api.inputs import RobotFile as RobotFile
    from expdesign.api.load import load as load
    from expdesign.api.load import load_model as load_model
    from expdesign.api.load import load_robot as load_robot
    from expdesign.api.load import read_recordings as read_recordings
    from expdesign.api.montecarlo import MonteCarlo as MonteCarlo
    from expdesign.api.montecarlo import montecarlo as montecarlo
    from expdesign.api.objects import Acceptance as Acceptance
    from expdesign.api.objects import Arm as Arm
    from expdesign.api.objects import Bipod as Bipod
    from expdesign.api.objects import Body as Body
    from expdesign.api.objects import Budget as Budget
    from expdesign.api.objects import Collisions as Collisions
    from expdesign.api.objects import Configuration as Configuration
    from expdesign.api.objects import Constraints as Constraints
    from expdesign.api.objects import Costs as Costs
    from expdesign.api.objects import DeflectionNoise as DeflectionNoise
    from expdesign.api.objects import Experiment as Experiment
    from expdesign.api.objects import Hexapod as Hexapod
    from expdesign.api.objects import KeepOut as KeepOut
    from expdesign.api.objects import LoadError as LoadError
    from expdesign.api.objects import MeasuredPoints as MeasuredPoints
    from expdesign.api.objects import ModelErrors as ModelErrors
    from expdesign.api.objects import Optimiser as Optimiser
    from expdesign.api.objects import Payload as Payload
    from expdesign.api.objects import Poses as Poses
    from expdesign.api.objects import Primitive as Primitive
    from expdesign.api.objects import ReferencePose as ReferencePose
    from expdesign.api.objects import Target as Target
    from expdesign.api.objects import TargetPayload as TargetPayload
    from expdesign.api.objects import Tilt as Tilt
    from expdesign.api.objects import Wrench as Wrench
    from expdesign.api.objects import load_configuration as load_configuration
    from expdesign.api.open_result import SavedResult as SavedResult
    from expdesign.api.open_result import open_result as open_result
    from expdesign.api.physics import Physics as Physics
    from expdesign.api.physics import physics as physics
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
    from expdesign.chain.declaration import Declaration as Declaration
    from expdesign.chain.declaration import Size as Size
    from expdesign.chain.effect import Effect as Effect
    from expdesign.chain.parameter import Parameter as Parameter
    from expdesign.criteria.criterion import Criterion as Criterion
    from expdesign.design.problem import DesignProblem as DesignProblem
    from expdesign.errors import ArgumentError as ArgumentError
    from expdesign.errors import ConvergenceError as ConvergenceError
    from expdesign.errors import ExpdesignError as ExpdesignError
    from expdesign.errors import InfeasibleError as InfeasibleError
    from expdesign.errors import InputError as InputError
    from expdesign.errors import NotIdentifiableError as NotIdentifiableError
    from expdesign.errors import SingularConfigurationError as SingularConfigurationError
    from expdesign.loads.errors.source import LoadErrorSource as LoadErrorSource
    from expdesign.models.model_file import Model as Model
    from expdesign.ports.port import Port as Port
    from expdesign.recordings.recordings import Recordings as Recordings
    from expdesign.robots.parallel import ParallelRobot as ParallelRobot
    from expdesign.robots.robot import Robot as Robot
    from expdesign.sweeps.engine import WorkersError as WorkersError

__version__ = "0.1.0"

_TYPES = {
    "Acceptance": "api.objects",
    "ArgumentError": "errors",
    "Arm": "api.objects",
    "Bipod": "api.objects",
    "Body": "api.objects",
    "Budget": "api.objects",
    "Checked": "api.check",
    "CheckedModel": "api.check",
    "CheckedProblem": "api.check",
    "CheckedRecordings": "api.check",
    "CheckedRobot": "api.check",
    "CheckedSweep": "api.check",
    "Collisions": "api.objects",
    "Commands": "api.compensate",
    "Comparison": "api.compare",
    "Configuration": "api.objects",
    "Constraints": "api.objects",
    "ConvergenceError": "errors",
    "Corrected": "api.correct",
    "Corrections": "api.table",
    "Costs": "api.objects",
    "Criterion": "criteria.criterion",
    "Declaration": "chain.declaration",
    "DeflectionNoise": "api.objects",
    "DesignProblem": "design.problem",
    "Diagnosed": "api.diagnose",
    "Effect": "chain.effect",
    "Evaluation": "api.evaluate",
    "ExpdesignError": "errors",
    "Experiment": "api.objects",
    "Hexapod": "api.objects",
    "Identified": "api.identify",
    "InfeasibleError": "errors",
    "InputError": "errors",
    "KeepOut": "api.objects",
    "LaboratorySheet": "api.sheet",
    "LoadError": "api.objects",
    "LoadErrorSource": "loads.errors.source",
    "MeasuredPoints": "api.objects",
    "Model": "models.model_file",
    "ModelErrors": "api.objects",
    "MonteCarlo": "api.montecarlo",
    "NotIdentifiableError": "errors",
    "Optimiser": "api.objects",
    "ParallelRobot": "robots.parallel",
    "Parameter": "chain.parameter",
    "Payload": "api.objects",
    "Physics": "api.physics",
    "PlannedNext": "api.plan_next",
    "Port": "ports.port",
    "Poses": "api.objects",
    "Predicted": "api.predict",
    "Primitive": "api.objects",
    "Recordings": "recordings.recordings",
    "ReferencePose": "api.objects",
    "Registered": "api.register",
    "Robot": "robots.robot",
    "RobotFile": "api.inputs",
    "Run": "api.run",
    "SavedResult": "api.open_result",
    "Simulated": "api.simulate",
    "SingularConfigurationError": "errors",
    "Size": "chain.declaration",
    "Sweep": "api.sweep",
    "Target": "api.objects",
    "TargetPayload": "api.objects",
    "Tilt": "api.objects",
    "Verified": "api.verify",
    "WorkersError": "sweeps.engine",
    "Wrench": "api.objects",
    "load_configuration": "api.objects",
    "load_model": "api.load",
    "load_robot": "api.load",
    "read_recordings": "api.load",
}


@_functools.cache
def _functions() -> list[str]:
    """Names of the modules of `expdesign.api` that define a function of their own name."""
    folder = _pathlib.Path(__file__).parent / "api"
    return [file.stem for file in sorted(folder.glob("*.py")) if f"\ndef {file.stem}(" in file.read_text("utf-8")]


def __getattr__(name: str) -> _typing.Any:
    if name in _TYPES:
        found = getattr(_importlib.import_module(f"expdesign.{_TYPES[name]}"), name)
    elif not name.startswith("_") and name in _functions():
        found = getattr(_importlib.import_module(f"expdesign.api.{name}"), name)
    else:
        raise AttributeError(f"module `expdesign` has no attribute `{name}`")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({"__version__", *_functions(), *_TYPES})
