"""Plan and evaluate the calibration of robots that carry loads.

The package reads like the command line (`docs/api.ipynb`):

    import expdesign as xd

    run = xd.run("configs/hexapod-h1.yaml")     # the Pareto front, as frames and typed objects
    run.plan                                    # what to measure
    run.save("results/mine")                    # the files of `expdesign run`

What is used is imported when it is first used. It has the name of its command, except
`plan_next`, because `next` is a builtin. Results are typed. Robots and configurations can be made as objects
(`xd.Hexapod`, `xd.Configuration`).
"""

import ast as _ast
import functools as _functools
import importlib as _importlib
import pathlib as _pathlib
import typing as _typing

if _typing.TYPE_CHECKING:  # the one list of what is exported; `__getattr__` reads it and imports what is used
    from expdesign.app.api.check import check as check
    from expdesign.app.api.compare import compare as compare
    from expdesign.app.api.compensate import compensate as compensate
    from expdesign.app.api.correct import correct as correct
    from expdesign.app.api.diagnose import diagnose as diagnose
    from expdesign.app.api.evaluate import evaluate as evaluate
    from expdesign.app.api.extend import extend as extend
    from expdesign.app.api.identify import identify as identify
    from expdesign.app.api.inputs import load_model as load_model
    from expdesign.app.api.inputs import load_robot as load_robot
    from expdesign.app.api.load import SavedResult as SavedResult
    from expdesign.app.api.load import load as load
    from expdesign.app.api.load import open_result as open_result
    from expdesign.app.api.montecarlo import montecarlo as montecarlo
    from expdesign.app.api.objects import Acceptance as Acceptance
    from expdesign.app.api.objects import Arm as Arm
    from expdesign.app.api.objects import Bipod as Bipod
    from expdesign.app.api.objects import Body as Body
    from expdesign.app.api.objects import Budget as Budget
    from expdesign.app.api.objects import Collisions as Collisions
    from expdesign.app.api.objects import Configuration as Configuration
    from expdesign.app.api.objects import Constraints as Constraints
    from expdesign.app.api.objects import Costs as Costs
    from expdesign.app.api.objects import DeflectionNoise as DeflectionNoise
    from expdesign.app.api.objects import Experiment as Experiment
    from expdesign.app.api.objects import Hexapod as Hexapod
    from expdesign.app.api.objects import KeepOut as KeepOut
    from expdesign.app.api.objects import LoadError as LoadError
    from expdesign.app.api.objects import MeasuredPoints as MeasuredPoints
    from expdesign.app.api.objects import ModelErrors as ModelErrors
    from expdesign.app.api.objects import Optimiser as Optimiser
    from expdesign.app.api.objects import Payload as Payload
    from expdesign.app.api.objects import Poses as Poses
    from expdesign.app.api.objects import Primitive as Primitive
    from expdesign.app.api.objects import ReferencePose as ReferencePose
    from expdesign.app.api.objects import Target as Target
    from expdesign.app.api.objects import TargetPayload as TargetPayload
    from expdesign.app.api.objects import Tilt as Tilt
    from expdesign.app.api.objects import Wrench as Wrench
    from expdesign.app.api.objects import load_configuration as load_configuration
    from expdesign.app.api.physics import physics as physics
    from expdesign.app.api.plan_next import plan_next as plan_next
    from expdesign.app.api.predict import predict as predict
    from expdesign.app.api.recorded import read_recordings as read_recordings
    from expdesign.app.api.register import register as register
    from expdesign.app.api.run import run as run
    from expdesign.app.api.schema import schema as schema
    from expdesign.app.api.sheet import sheet as sheet
    from expdesign.app.api.simulate import simulate as simulate
    from expdesign.app.api.sweep import SweepResult as SweepResult
    from expdesign.app.api.sweep import sweep as sweep
    from expdesign.app.api.table import table as table
    from expdesign.app.api.verify import verify as verify
    from expdesign.app.parallel import WorkersError as WorkersError
    from expdesign.chain.declaration import Declaration as Declaration
    from expdesign.chain.declaration import Parameter as Parameter
    from expdesign.chain.declaration import Size as Size
    from expdesign.chain.effect import Effect as Effect
    from expdesign.chain.models.model_file import Model as Model
    from expdesign.chain.ports.port import Port as Port
    from expdesign.chain.recordings.recordings import Recordings as Recordings
    from expdesign.errors import ArgumentError as ArgumentError
    from expdesign.errors import ConvergenceError as ConvergenceError
    from expdesign.errors import ExpdesignError as ExpdesignError
    from expdesign.errors import InfeasibleError as InfeasibleError
    from expdesign.errors import InputError as InputError
    from expdesign.errors import NotIdentifiableError as NotIdentifiableError
    from expdesign.errors import SingularConfigurationError as SingularConfigurationError
    from expdesign.mechanics.loads.errors.source import LoadErrorSource as LoadErrorSource
    from expdesign.mechanics.robots.parallel import ParallelRobot as ParallelRobot
    from expdesign.mechanics.robots.robot import Robot as Robot
    from expdesign.mechanics.robots.robot_file import RobotFile as RobotFile
    from expdesign.planning.criteria.criterion import Criterion as Criterion
    from expdesign.planning.problem import DesignProblem as DesignProblem
    from expdesign.report.check_texts import CheckResult as CheckResult
    from expdesign.report.comparison_report import ComparisonResult as ComparisonResult
    from expdesign.report.compensation_texts import CompensationResult as CompensationResult
    from expdesign.report.compensation_texts import CorrectionTableResult as CorrectionTableResult
    from expdesign.report.design_report import RunResult as RunResult
    from expdesign.report.diagnosis_report import DiagnosisResult as DiagnosisResult
    from expdesign.report.identification_report import IdentificationResult as IdentificationResult
    from expdesign.report.laboratory_sheet import SheetResult as SheetResult
    from expdesign.report.montecarlo_report import MonteCarloResult as MonteCarloResult
    from expdesign.report.physics_texts import PhysicsResult as PhysicsResult
    from expdesign.report.plan_results import EvaluationResult as EvaluationResult
    from expdesign.report.plan_results import NextResult as NextResult
    from expdesign.report.recording_texts import CorrectionResult as CorrectionResult
    from expdesign.report.recording_texts import PredictionResult as PredictionResult
    from expdesign.report.recording_texts import RegistrationResult as RegistrationResult
    from expdesign.report.recording_texts import SimulationResult as SimulationResult
    from expdesign.report.verification_report import VerificationResult as VerificationResult

__version__ = "0.1.0"


@_functools.cache
def _exported() -> dict[str, str]:
    """Modules by the names that the block for type checkers imports from them, read off this file."""
    tree = _ast.parse(_pathlib.Path(__file__).read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, _ast.If))
    imports = (node for node in block.body if isinstance(node, _ast.ImportFrom))
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def __getattr__(name: str) -> _typing.Any:
    if name.startswith("_") or name not in _exported():
        raise AttributeError(f"module `expdesign` has no attribute `{name}`")
    found = globals()[name] = getattr(_importlib.import_module(_exported()[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted({"__version__", *_exported()})
