"""`model.yaml`: an identified robot as a file, with everything that prediction and compensation need.

The file carries the robot written out, the compliances, the effects that were found, each by its physics, component
and variant with its parameters, and the covariance of all of them. Reading it gives back the same `Chain`, values and
covariance, number for number.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.markers import MarkerReading
from expdesign.errors import InputError
from expdesign.files.kinds import require_kind
from expdesign.files.schema import Number, Section, validate
from expdesign.files.yaml_reader import YamlDocument, read_yaml
from expdesign.identification.fit import Fit
from expdesign.plugins import implementations
from expdesign.ports.law import Law, form_data, form_of
from expdesign.robots.robot import Robot
from expdesign.robots.robot_file import robot_from_document


@dataclass(frozen=True)
class Model:
    """A robot as it was identified.

    Attributes:
        chain: the robot with its effects.
        values: parameters of the chain, shape (p,).
        covariance: of the parameters, shape (p, p); infinite for parameters that the recordings did not determine.
        robot: the content of the robot file.
        folder: what relative paths in `robot` are relative to.
        source: name of the file it was read from, or of the recordings.
    """

    chain: Chain
    values: FloatArray
    covariance: FloatArray
    robot: Mapping[str, Any]
    folder: Path
    source: str

    @classmethod
    def from_fit(cls, fit: Fit, robot: YamlDocument, source: str) -> "Model":
        """The model of a fit of the robot that the document `robot` describes."""
        return cls(fit.chain, fit.values, fit.covariance, robot.content, robot.folder, source)

    @property
    def compliance(self) -> FloatArray:
        """Compliances in m/N or rad/(N·m), shape (n_p,)."""
        return self.values[: self.chain.compliances] * self.chain.robot.compliance


class _EffectSection(Section):
    physics: str
    component: str
    variant: str = ""
    parameters: dict[str, Number]
    law: dict[str, Any] | None = None


class _ModelSection(Section):
    kind: str
    schema_version: int
    identified_from: str = ""
    robot: dict[str, Any]
    compliance: dict[str, Number]
    instrument: dict[str, Number] = Field(default_factory=dict)
    markers: list[str] | None = None
    held: list[list[str]] = Field(default_factory=list)
    effects: list[_EffectSection]
    parameters: list[str]
    covariance: list[list[float]]


def model_text(model: Model, folder: Path) -> str:
    """The content of a model file that will stand in `folder`."""
    scale = _units(model.chain)
    robot = dict(model.robot)
    if isinstance(robot.get("urdf"), str):
        robot["urdf"] = os.path.relpath(model.folder / robot["urdf"], folder)
    effects = []
    for effect, part in zip(model.chain.effects, model.chain.slices, strict=True):
        names = [parameter.name for parameter in effect.parameters]
        entry: dict[str, Any] = {
            "physics": effect.physics,
            "component": effect.component,
            "variant": effect.variant,
            "parameters": dict(zip(names, model.values[part].tolist(), strict=True)),
        }
        if isinstance(effect, Law):
            entry["law"] = form_data(effect.form)
        effects.append(entry)
    content = {
        "kind": "model",
        "schema_version": 1,
        "identified_from": model.source,
        "robot": robot,
        "compliance": dict(zip(model.chain.robot.actuators, model.compliance.tolist(), strict=True)),
        **_instrument_of(model),
        "effects": effects,
        "parameters": _names(model.chain),
        "covariance": (model.covariance * np.outer(scale, scale)).tolist(),
    }
    head = (
        "# Identified model, for `expdesign predict`, `compensate` and `simulate`. Compliances in m/N (rad/(N m));\n"
        "# the covariance is of all `parameters` in their own units.\n"
    )
    return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120, allow_unicode=True)


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
        raise InputError("this is not a model file", where=document.where(), remedy=remedy)
    section = validate(_ModelSection, document)
    if section.schema_version != 1:
        what = f"schema version {section.schema_version} is not known"
        raise InputError(what, where=document.where(("schema_version",)), remedy="Only version 1 is.")
    robot = robot_from_document(document.part("robot"))
    effects = tuple(
        _effect(entry, robot_effect_classes(), robot, document, index) for index, entry in enumerate(section.effects)
    )
    chain = Chain(robot, effects, markers=_markers(section, robot, document))
    if tuple(section.compliance) != robot.actuators:
        remedy = f"They must be {', '.join(robot.actuators)}, in this order."
        raise InputError("these are not the robot's actuators", where=document.where(("compliance",)), remedy=remedy)
    values = [np.array(list(section.compliance.values())) * robot.stiffness]
    values.append(np.array(list(section.instrument.values())))
    for effect, entry in zip(effects, section.effects, strict=True):
        values.append(np.array([entry.parameters[parameter.name] for parameter in effect.parameters]))
    covariance = _covariance(section, chain, document)
    scale = _units(chain)
    joined = np.concatenate(values)
    return Model(
        chain=chain,
        values=joined,
        covariance=covariance / np.outer(scale, scale),
        robot=section.robot,
        folder=document.folder,
        source=document.source,
    )


def _instrument_of(model: Model) -> dict[str, Any]:
    """The instrument and the markers of a model of positions, as the file has them."""
    chain = model.chain
    if chain.markers is None:
        return {}
    names = [parameter.name for parameter in chain.markers.parameters]
    values = model.values[chain.compliances : chain.base].tolist()
    return {
        "instrument": dict(zip(names, values, strict=True)),
        "markers": list(chain.markers.names),
        "held": [list(pair) for pair in chain.markers.held],
    }


def _markers(section: _ModelSection, robot: Robot, document: YamlDocument) -> MarkerReading | None:
    if section.markers is None:
        return None
    places = {name: place for name, place in robot.markers.items() if name in section.markers}
    start = np.array(list(section.instrument.values()))
    held = tuple((str(pair[0]), str(pair[-1])) for pair in section.held)
    reading = MarkerReading(tuple(section.markers), places, robot.instrument, start, held)
    expected = [parameter.name for parameter in reading.parameters]
    if list(section.instrument) != expected:
        remedy = f"They must be {', '.join(expected)}, in this order."
        raise InputError(
            "these are not the instrument's parameters", where=document.where(("instrument",)), remedy=remedy
        )
    return reading


def _covariance(section: _ModelSection, chain: Chain, document: YamlDocument) -> FloatArray:
    """The covariance of the file; infinite variances mark what was not determined."""
    where = document.where(("covariance",))
    if section.parameters != _names(chain):
        remedy = f"They must be {', '.join(_names(chain))}, in this order."
        raise InputError("these are not the model's parameters", where=document.where(("parameters",)), remedy=remedy)
    count = len(chain.parameters)
    rows = section.covariance
    if len(rows) != count or any(len(row) != count for row in rows) or np.isnan(rows).any():
        what = f"a matrix of {count}×{count} numbers is needed here"
        raise InputError(what, where=where, remedy="Order: `parameters`.")
    covariance = np.array(rows, dtype=float)
    known = np.isfinite(np.diag(covariance))
    inner = covariance[np.ix_(known, known)]
    if np.any(np.diag(covariance) < 0.0) or not np.allclose(inner, inner.T, rtol=1e-6, atol=0.0):
        remedy = "Identify or diagnose the recordings again."
        raise InputError("a covariance is symmetric with a diagonal of variances", where=where, remedy=remedy)
    return covariance


def robot_effect_classes() -> list[type[Effect]]:
    """Every effect that lies in `chain/effects`."""
    return implementations("expdesign.chain.effects", Effect)  # type: ignore[type-abstract]


def _effect(entry: _EffectSection, known: list[type[Effect]], robot: Any, document: YamlDocument, index: int) -> Effect:
    """The effect of an entry: the known one of that physics whose parameters bear the same names."""
    where = document.where(("effects", index))
    if entry.law is not None:
        return _law(entry, robot, where)
    of_physics = [cls for cls in known if cls.physics == entry.physics]
    if not of_physics:
        remedy = f"Known: {', '.join(sorted({cls.physics for cls in known})) or 'none'}."
        raise InputError(f"unknown physics `{entry.physics}`", where=where, remedy=remedy)
    for cls in of_physics:
        try:
            effect = cls(robot, entry.component, entry.variant)
        except (ValueError, KeyError, IndexError):
            continue
        if {parameter.name for parameter in effect.parameters} == set(entry.parameters):
            return effect
    what = f"`{entry.physics}` at `{entry.component}` does not have these parameters on this robot"
    raise InputError(what, where=where, remedy="Identify or diagnose the recordings again with this version.")


def _law(entry: _EffectSection, robot: Robot, where: str) -> Law:
    """The law of an entry, from its data."""
    assert entry.law is not None
    try:
        law = Law(robot, form_of(entry.law, entry.component), int(entry.variant.split()[-1]))
        known = {parameter.name for parameter in law.parameters} == set(entry.parameters)
    except (KeyError, TypeError, ValueError, IndexError):
        known = False
    if not known:
        remedy = "Diagnose the recordings again with this version."
        raise InputError("this is not a law as this version writes it", where=where, remedy=remedy)
    return law


def _units(chain: Chain) -> FloatArray:
    """Factors from the chain's parameters to those of the file: compliances in m/N, effects as they are."""
    return np.concatenate([chain.robot.compliance, np.ones(len(chain.parameters) - chain.compliances)])


def _names(chain: Chain) -> list[str]:
    names = [f"{name} compliance" for name in chain.robot.actuators]
    names += [parameter.name for parameter in chain.parameters[chain.compliances : chain.base]]
    return names + [f"{effect.key} / {p.name}" for effect in chain.effects for p in effect.parameters]
