"""The part of a run configuration that says what is calibrated, and how its poses are measured."""

from expdesign.errors import InputError
from expdesign.io.yaml_reader import KeyPath, YamlDocument
from expdesign.mechanics.elastostatics.regressors.elastostatic import Elastostatic
from expdesign.mechanics.elastostatics.regressors.regressor import Regressor
from expdesign.mechanics.elastostatics.regressors.stacked import regressor_for
from expdesign.mechanics.robots.robot import Robot
from expdesign.planning.schema import ExperimentSection, LoadSection, RunSection

_EXPERIMENT: KeyPath = ("experiment",)


def read_regressor(section: RunSection, robot: Robot, document: YamlDocument) -> Regressor:
    """The regressor of `experiment.calibration` and `experiment.frames`.

    Raises:
        InputError: the robot has no such calibration, or loads and frames do not go with it.
    """
    experiment = section.experiment
    known, links = experiment.frames == "known", robot.links is not None
    regressor = regressor_for(experiment.calibration, frames_known=known, links=links)
    lack = regressor.require(robot)
    if lack is not None:
        where = document.where((*_EXPERIMENT, "calibration"))
        raise InputError(f"{lack}, and `{robot.name}` is a {robot.kind}", where=where, remedy="Use `elastostatic`.")
    elastostatic = isinstance(regressor, Elastostatic)
    if elastostatic and experiment.frames == "unknown":
        what = "deflections are differences, in which unknown frames cancel"
        raise InputError(what, where=document.where((*_EXPERIMENT, "frames")), remedy="Take the key out.")
    if not elastostatic and experiment.deflection_noise.shared_reference:
        what = "geometric calibration measures poses, which have no unloaded reference to share"
        where = document.where((*_EXPERIMENT, "deflection_noise", "shared_reference"))
        raise InputError(what, where=where, remedy="Take the key out.")
    _require_loads(section, regressor, document)
    return regressor


def _require_loads(section: RunSection, regressor: Regressor, document: YamlDocument) -> None:
    experiment = section.experiment
    if regressor.needs_load:
        if experiment.load is None:
            raise InputError("the key is missing", where=document.where((*_EXPERIMENT, "load")), remedy="Add it.")
        for index, target in enumerate(section.targets):
            if target.payload is None and target.wrench is None:
                what = "exactly one of `payload` and `wrench` is needed"
                raise InputError(what, where=document.where(("targets", index)), remedy="Add one.")
        return
    remedy = "Take it out, or use `calibration: both`."
    for key in ("load", "load_error", "geometric_stiffness"):
        if getattr(experiment, key):
            what = "geometric calibration measures poses without load"
            raise InputError(what, where=document.where((*_EXPERIMENT, key)), remedy=remedy)
    for index, target in enumerate(section.targets):
        for key in ("payload", "wrench"):
            if getattr(target, key) is not None:
                what = "geometric calibration knows nothing of what a load does at a target"
                raise InputError(what, where=document.where(("targets", index, key)), remedy=remedy)


def load_section(experiment: ExperimentSection) -> LoadSection:
    """`experiment.load`, or a wrench that is zero where measurements have no load."""
    return experiment.load or LoadSection(kind="wrench")
