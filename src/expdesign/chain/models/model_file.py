"""`model.yaml`: an identified robot as a file, with everything that prediction and compensation need.

The file carries the robot written out, the compliances, the effects that were found, each by its identifier, component
and variant with its parameters, and the covariance of all of them. Reading it gives back the same `Chain`, values and
covariance, number for number.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.acting import ActingLoads, ActingSection, acting_entry, acting_of
from expdesign.chain.models.checked import covariance_of, relative_compliances, require_ordered, require_yielding
from expdesign.chain.models.drawn import Drawn, DrawnSection, drawn_entry, drawn_of
from expdesign.chain.models.effect_entry import EffectSection, effect_entry, effect_of, require_identifiers
from expdesign.chain.models.estimable import Calibrated, Estimable, EstimableSection, estimable_entry, subspace_of
from expdesign.chain.models.matrix_rows import MatrixRows, matrix_rows
from expdesign.chain.readings.position import LISTED, MarkerPosition
from expdesign.chain.readings.reading import DEFLECTION, MeasuredPose, Reading
from expdesign.copying import Copied
from expdesign.io.kinds import CURRENT_VERSIONS, require_kind
from expdesign.io.schema import Number, Positive, Section, validate
from expdesign.io.yaml_reader import YamlDocument, read_yaml, yaml_text
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import robot_from_document


class ModelSource(Protocol):
    """What a model takes from a fit: the chain, its values (p,), and the covariance of their combinations."""

    @property
    def chain(self) -> Chain: ...

    @property
    def values(self) -> FloatArray: ...

    @property
    def estimable(self) -> Estimable: ...


@dataclass(frozen=True, repr=False)
class Model(Copied):
    """A robot as it was identified.

    Attributes:
        chain: the robot with its effects.
        values: parameters of the chain, shape (p,).
        covariance: of the parameters, shape (p, p); infinite for parameters that the recordings did not determine.
        robot: the content of the robot file.
        folder: what relative paths in `robot` are relative to.
        source: name of the file it was read from, or of the recordings.
        subspace: what is known of combinations of parameters; None where each is determined or not for itself.
        birge_ratio: by which standard deviations allow for a model that the recordings refute, 1 where they do not.
        reading_std: standard deviation of a reading of the recordings (m, rad), widened as the fit asks for, by the
            column that states it; empty where it is not known.
        fit: what the recordings say of the model (`goodness.Verdict`); empty where that is not known.
        calibrated: ranges of the recordings; None where they are not known.
        acting: errors of the recorded loads that act at targets as well; None where there are none.
        drawn: what no reading shows of an arm's tip; None for nothing.
    """

    chain: Chain
    values: FloatArray
    covariance: FloatArray
    robot: Mapping[str, Any]
    folder: Path
    source: str
    subspace: Estimable | None = None
    birge_ratio: float = 1.0
    reading_std: Mapping[str, float] = field(default_factory=dict)
    fit: str = ""
    calibrated: Calibrated | None = None
    acting: ActingLoads | None = None
    drawn: Drawn | None = None

    def __repr__(self) -> str:
        effects = ", ".join(f"{effect.physics} at {effect.component}" for effect in self.chain.effects)
        return f"<Model of {self.chain.robot.name}: {effects or 'stiffnesses'} ({self.source})>"

    @classmethod
    def from_fit(cls, fit: ModelSource, robot: YamlDocument, source: str) -> "Model":
        """The model of a fit to the robot that a document describes, its covariance as it predicts."""
        known = fit.estimable
        return cls(fit.chain, fit.values, known.covariance, robot.content, robot.folder, source, known)

    @property
    def at_targets(self) -> "Model":
        """The model of what acts at targets: with the errors of the recorded loads among its effects."""
        if self.acting is None or not self.acting.effects:
            return self
        chain, known = self.chain, self.acting.joined(self.estimable)
        longer = Chain(chain.robot, (*chain.effects, *self.acting.effects), reading=chain.reading)
        values = np.concatenate([self.values, self.acting.values])
        # The effects have joined the model; what every loading has for itself is left.
        own = replace(self.acting, effects=(), values=np.zeros(0), covariance=np.zeros((0, len(values))))
        return replace(self, chain=longer, values=values, covariance=known.covariance, subspace=known, acting=own)

    @property
    def estimable(self) -> Estimable:
        """The covariance of every combination of parameters that the recordings determined."""
        return Estimable.from_covariance(self.covariance) if self.subspace is None else self.subspace

    @property
    def compliance(self) -> FloatArray:
        """Compliances in m/N or rad/(N·m), shape (n_p,)."""
        return self.values[: self.chain.compliances] * self.chain.robot.compliance


class _ModelSection(Section):
    kind: str
    schema_version: int
    identified_from: str = ""
    robot: dict[str, Any]
    compliance: dict[str, Number]
    relative_compliance: list[Number] = Field(default_factory=list)
    instrument: dict[str, Number] = Field(default_factory=dict)
    markers: list[str] | None = None
    held: list[list[str]] = Field(default_factory=list)
    oriented: list[str] = Field(default_factory=list)
    fixed: list[str] = Field(default_factory=list)
    gauges: list[str] = Field(default_factory=list)
    unplaced: bool = False
    sites: list[str] = Field(default_factory=list)
    stations: list[str] = Field(default_factory=list)
    frames: Literal["known", "unknown"] | None = None
    effects: list[EffectSection]
    parameters: list[str]
    covariance: MatrixRows
    estimable: EstimableSection | None = None
    load_errors: ActingSection | None = None
    drawing: DrawnSection | None = None
    birge_ratio: Annotated[Number, Field(gt=0.0)] = 1.0  # earlier versions wrote ratios below 1
    reading_std: dict[str, Positive] = Field(default_factory=dict)
    fit: str = ""
    calibrated: dict[str, Annotated[list[Number], Field(min_length=2, max_length=2)]] = Field(default_factory=dict)


def model_text(model: Model, folder: Path) -> str:
    """The content of a model file that will stand in `folder`."""
    scale = _units(model.chain)
    robot = dict(model.robot)
    if isinstance(robot.get("urdf"), str):
        robot["urdf"] = os.path.relpath(model.folder / robot["urdf"], folder)
    effects = [
        effect_entry(effect, model.values[part].tolist())
        for effect, part in zip(model.chain.effects, model.chain.slices, strict=True)
    ]
    content = {
        "kind": "model",
        "schema_version": CURRENT_VERSIONS["identified model"],
        "identified_from": model.source.encode("utf-8", "replace").decode("utf-8"),
        **({"calibrated": {k: list(v) for k, v in model.calibrated.ranges.items()}} if model.calibrated else {}),
        "robot": robot,
        "compliance": dict(zip(model.chain.robot.actuators, model.compliance.tolist(), strict=True)),
        "relative_compliance": model.values[: model.chain.compliances].tolist(),
        **_instrument_of(model),
        "effects": effects,
        "parameters": _names(model.chain),
        "covariance": matrix_rows(model.covariance * np.outer(scale, scale)),
        **({} if model.birge_ratio == 1.0 else {"birge_ratio": model.birge_ratio}),
        **({"reading_std": dict(model.reading_std)} if model.reading_std else {}),
        **({"fit": model.fit} if model.fit else {}),
        **estimable_entry(model.estimable.in_units(scale)),
        **acting_entry(model.acting, scale, model.chain.robot.coordinates),
        **drawn_entry(model.drawn, scale),
    }
    head = (
        "# Identified model, for `expdesign predict`, `compensate` and `simulate`. Compliances in m/N (rad/(N m));\n"
        "# the covariance is of all `parameters` in their own units.\n"
    )
    return head + yaml_text(content)


def model_of_robot(robot: Robot, document: YamlDocument) -> Model:
    """The base model of a robot as its file describes it, its stiffness taken as exact."""
    chain = Chain(robot, ())
    count = len(chain.parameters)
    return Model(chain, np.ones(count), np.zeros((count, count)), document.content, document.folder, document.source)


def read_model(path: Path) -> Model:
    """The model in a file.

    Raises:
        InputError: the file is missing or wrong, or names an effect that this version does not know.
    """
    return model_from_document(read_yaml(path))


def model_from_document(document: YamlDocument) -> Model:
    """The model in a document; see `read_model`."""
    require_kind(document, "identified model")
    content = document.content
    if not isinstance(content, dict) or content.get("kind") != "model":
        remedy = "`expdesign identify` and `expdesign diagnose` write model files (`kind: model`)."
        raise document.where().fault("this is not a model file", remedy)
    section = validate(_ModelSection, document)
    robot = robot_from_document(document.where("robot"))
    effects = tuple(effect_of(entry, robot) for entry in section.effects)
    if section.schema_version > 1:
        require_identifiers(section.effects)
    chain = Chain(robot, effects, reading=_reading(section, robot))
    if tuple(section.compliance) != robot.actuators:
        remedy = f"They must be {', '.join(robot.actuators)}, in this order."
        raise section.where("compliance").fault("these are not the robot's actuators", remedy)
    values = [relative_compliances(section.compliance, section.relative_compliance, robot, section.where())]
    values.append(np.array(list(section.instrument.values())))
    for effect, entry in zip(effects, section.effects, strict=True):
        values.append(np.array([entry.parameters[parameter.name] for parameter in effect.parameters]))
    scale = _units(chain)
    covariance = _covariance(section, chain) / np.outer(scale, scale)
    require_yielding(values[0], covariance, robot, section.where())
    require_ordered(section.calibrated, section.where("calibrated"))
    joined = np.concatenate(values)
    subspace = subspace_of(section.estimable, len(scale), 1.0 / scale)
    known = Estimable.from_covariance(covariance) if subspace is None else subspace
    return Model(
        chain=chain,
        values=joined,
        covariance=covariance,
        subspace=subspace,
        acting=acting_of(section.load_errors, robot, known, scale),
        drawn=drawn_of(section.drawing, scale),
        birge_ratio=section.birge_ratio,
        reading_std=section.reading_std,
        fit=section.fit,
        calibrated=Calibrated({k: (v[0], v[1]) for k, v in section.calibrated.items()}) if section.calibrated else None,
        robot=section.robot,
        folder=document.folder,
        source=document.source,
    )


def _instrument_of(model: Model) -> dict[str, Any]:
    """The instrument and the markers of a model of positions, as the file has them."""
    chain = model.chain
    record = chain.reading.record
    if not record:
        return {}
    names = [parameter.name for parameter in chain.reading.parameters]
    values = model.values[chain.compliances : chain.base].tolist()
    return {"instrument": dict(zip(names, values, strict=True)), **record}


def _reading(section: _ModelSection, robot: Robot) -> Reading:
    if section.frames is not None:
        return MeasuredPose(section.frames == "known")
    if not section.markers:
        return DEFLECTION
    places = {name: place for name, place in robot.markers.items() if name in (section.sites or section.markers)}
    start = np.array(list(section.instrument.values()))
    held = tuple((str(pair[0]), str(pair[-1])) for pair in section.held)
    reading = MarkerPosition(
        tuple(section.markers),
        places,
        np.zeros(6) if section.unplaced else robot.instrument,
        start,
        held,
        unplaced=section.unplaced,
        **{name: tuple(getattr(section, name)) for name in LISTED},
    )
    expected = [parameter.name for parameter in reading.parameters]
    if list(section.instrument) != expected:
        remedy = f"They must be {', '.join(expected)}, in this order."
        raise section.where("instrument").fault("these are not the instrument's parameters", remedy)
    return reading


def _covariance(section: _ModelSection, chain: Chain) -> FloatArray:
    """The covariance of the file in its units; infinite variances mark what was not determined."""
    if section.parameters != _names(chain):
        remedy = f"They must be {', '.join(_names(chain))}, in this order."
        raise section.where("parameters").fault("these are not the model's parameters", remedy)
    return covariance_of(section.covariance, len(chain.parameters), section.where("covariance"))


def _units(chain: Chain) -> FloatArray:
    """Factors from the chain's parameters to those of the file: compliances in m/N, effects as they are."""
    compliance = np.where(chain.robot.compliance > 0.0, chain.robot.compliance, 1.0)
    return np.concatenate([compliance, np.ones(len(chain.parameters) - chain.compliances)])


def _names(chain: Chain) -> list[str]:
    names = [f"{name} compliance" for name in chain.robot.actuators]
    names += [parameter.name for parameter in chain.parameters[chain.compliances : chain.base]]
    return names + [f"{effect.key} / {p.name}" for effect in chain.effects for p in effect.parameters]
