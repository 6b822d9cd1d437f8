"""What a calibration of an arm found, as people know it: origins of joints, frames, and a corrected URDF."""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.readings.position import INSTRUMENT, TURN, MarkerPosition
from expdesign.chain.recordings.recordings import Recordings
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.corrected_urdf import Attached, corrected_origins, corrected_urdf, pose_of
from expdesign.estimation.intervals import Intervals
from expdesign.mechanics.robots.common_normals import as_in_file


@dataclass(frozen=True)
class Corrected:
    """One parameter of the geometry.

    Attributes:
        label: for people; name: in model files.
        unit: `m` or `rad`.
        value, low, high: true minus nominal, with the 95 % interval.
        status: `told apart`, `hardly shown` (it stays near the drawing), `stands in others`, or `held` (on request).
        note: which others, or empty.
    """

    label: str
    name: str
    unit: str
    value: float
    low: float
    high: float
    status: str
    note: str


def corrections(found: ArmCalibration, geometry: Intervals | None) -> list[Corrected]:
    """The parameters of the geometry in the order of the chain; none for a calibration without it."""
    chain = found.fit.chain
    notes = {each.name: each.sentence for each in found.redundant}
    listed = []
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if not isinstance(effect, CalibratedGeometryError) or geometry is None:
            continue
        for own, index in enumerate(range(part.start, part.stop)):
            label = found.labels[index]
            status = "told apart" if found.told_apart[index] else "hardly shown"
            interval = (float(geometry.estimate[own]), float(geometry.low[own]), float(geometry.high[own]))
            unit = effect.parameters[own].name.rpartition("_")[2]
            status = "stands in others" if label in notes else status
            status = "held" if index not in found.minimal.kept and label not in notes else status
            name = effect.parameters[own].name
            listed.append(Corrected(label, name, unit, *interval, status, notes.get(label, "")))
    return listed


def geometric_errors(chain: Chain, values: FloatArray) -> FloatArray:
    """Geometric errors of the robot's tree in the order of `tree.geometry_names`."""
    errors = np.zeros(chain.robot.links.tree.size)
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if isinstance(effect, CalibratedGeometryError):
            errors[list(effect.indices)] += values[part]
    return errors


def origins(found: ArmCalibration) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Nominal and corrected origin (x, y, z, rx, ry, rz) of every joint of the URDF that has an error."""
    chain = found.fit.chain
    tree = chain.robot.links.tree
    corrected = corrected_origins(tree, geometric_errors(chain, found.fit.values))
    drawn = {name: as_in_file(tree.urdf, joint, joint.origin) for name, joint in tree.urdf.joints.items()}
    return {name: (pose_of(drawn[name]), pose_of(matrix)) for name, matrix in corrected.items()}


def attached_frames(found: ArmCalibration, recordings: Recordings) -> list[Attached]:
    """Instrument and markers as frames on the base and on the tips, as they were identified."""
    chain, values = found.fit.chain, found.fit.values
    reading = chain.reading
    if not isinstance(reading, MarkerPosition):
        return []
    tree = chain.robot.links.tree
    theta = values[chain.compliances : chain.base]
    frames = []
    for (kind, station), part in reading.parts.items():
        if kind == INSTRUMENT:
            frames.append(Attached("_".join(("identified_instrument", *station.split())), tree.base, theta[part]))
    tips = chain.robot.tip_numbers(recordings.configurations)
    places = dict(zip(reading.sited, reading.marked(theta), strict=True))
    for name, place in places.items():
        turn = theta[reading.parts[TURN, name]] if name in reading.oriented else np.zeros(3)
        rows: BoolArray = np.array([site == name for site in reading.sited])[recordings.marker]
        tip = int(tips[rows][0]) - 1 if len(tree.tips) > 1 and rows.any() else 0
        frames.append(Attached("_".join(("identified", *name.split())), tree.tips[tip], np.array([*place, *turn])))
    return frames


def calibrated_urdf(found: ArmCalibration, recordings: Recordings) -> str:
    """The URDF with the identified geometry, and instrument and markers as links."""
    chain = found.fit.chain
    errors = geometric_errors(chain, found.fit.values)
    return corrected_urdf(chain.robot.links.tree, errors, attached_frames(found, recordings))
