"""Laws in words that a technician understands: what kind, on what it depends, and what usually behaves like that."""

from collections.abc import Sequence

from expdesign.chain.ports.quantities import Quantity
from expdesign.mechanics.robots.robot import Robot

FORMS = {
    "compliance": "yields more or less, depending on",
    "force law": "does not yield in proportion: its deflection follows a curve of",
    "guide": "tilts the more the less its guides overlap, following a curve of",
    "guide friction": "keeps part of its tilt when the load changes, the more the less guides overlap; it remembers",
    "settling": "settles, whatever the load, depending on",
    "step at zero": "jumps where the sign changes of",
    "bracket": "gives way together with another leg, following a curve of",
    "friction": "keeps part of its deflection when the load changes, as dry friction does; it remembers",
    "latch": "gives way and stays there until it is pushed back; it remembers",
    "creep": "goes on moving under a load that stays; it remembers",
    "jump": "jumps once and stays there, depending on",
    "periodic": "has an error that repeats with",
    "offset": "is displaced, whatever the load, depending on",
    "field": "is acted on by a force that nothing in the recordings states, depending on",
    "hose": "is pulled, together with the joint after it, depending on",
    "contact": "is pushed by something that it touches, depending on",
    "load": "carries another load than stated, depending on",
    "scale": "shows deflections too large, too small or turned, depending on",
    "reading law": "does not read in proportion; its error depends on",
    "drift": "drifts with",
    "geometry": "is not as the robot file says",
    "loaded geometry": "changes as the machine yields, depending on",
    "joints": "has joints that resist being turned, depending on",
    "sticking": "bends until its joints slip, and keeps part of that when the load changes; it remembers",
    "twist": "tilts or shifts, depending on",
}
_USUAL = {
    "compliance": "a guide, a bearing or a spindle that is worn, clamped or free in part of its travel does that",
    "force law": "play, preload, rubber, contact and opening joints do that",
    "guide": "clearance and yielding pads of a telescope's guides do that",
    "guide friction": "dry friction in the guides of a telescope does that",
    "settling": "a floor, feet and tyres that give way slowly do that",
    "step at zero": "play and stick-slip do that",
    "bracket": "a bracket on which two legs stand does that, by its play or its spring",
    "friction": "guides, seals and clamped joints do that",
    "latch": "a clamp or a mount that slips does that",
    "creep": "plastics, rubber, adhesive and grease do that",
    "jump": "a clamp that slips, a knock and a screw that is tightened do that",
    "periodic": "screws, gears and encoders do that",
    "offset": "a scale that is off, or heat, does that",
    "field": "cables, hoses, springs, magnets and stops beside the machine do that",
    "hose": "hoses and cables that are led along an arm do that",
    "contact": "stops, collisions and tight cables do that",
    "load": "a wrong mass or centre of mass, and loads that shift or spill, do that",
    "scale": "optics, calibration and mounting of the instrument do that",
    "reading law": "the scale or the electronics of the instrument do that",
    "drift": "heat and settling feet do that",
    "geometry": "joints that are not where the drawing has them do that",
    "loaded geometry": "legs that turn with large deflections do that",
    "joints": "flexures, preloaded and dry bearings do that",
    "sticking": "dry or tightened joints at the ends of a leg do that",
    "twist": "bearings, guides and flanges do that",
}
_UNITS = {
    "effort": "N", "pair": "N", "ground": "N", "weight": "N", "length": "m", "position": "m",
    "clock": "s", "elapsed": "s", "started": "s", "settling": "", "slip": "rad",
    "warming": "K", "temperature": "degC", "warmth": "degC",
}  # fmt: skip


def quantity_name(quantity: Quantity, robot: Robot) -> str:
    """A quantity as people speak of it, with the actuator, axis or coordinate."""
    count = len(robot.stiffness)
    kind, index = quantity.kind, quantity.index
    if kind in ("effort", "effort_sign", "stop", "lag"):
        part, axis = divmod(index - count, robot.coordinates.n)
        what = robot.coordinates.wrench[axis] + ("" if part == 0 else " about the origin of O")
        if index < count:
            what = f"the {'moment' if robot.units[index] == 'rad' else 'force'} in {robot.actuators[index]}"
        prefix = {"effort_sign": "the sign of ", "stop": "the history of ", "lag": "the history of "}
        return prefix.get(kind, "") + what
    if kind in ("pair", "pair_sign"):
        other = robot.actuators[int(quantity.setting[0])]
        text = f"the force in {robot.actuators[index]} and {other} together"
        return f"the sign of {text}" if kind == "pair_sign" else text
    if kind in ("whole", "rest"):
        return _load(index, robot) + (" of the reference" if kind == "rest" else "")
    names = {
        "slip": "how far it was bent",
        "joint_moment": f"the moment about {'xyz'[index % 3]} of joint {index // 3 + 1}",
        "ground": f"{robot.coordinates.wrench[index % robot.coordinates.n]} about the origin of O",
        "length": f"the {_place(index, robot)} of {robot.actuators[index]}" if index < count else "length",
        "overlap": f"what {robot.configuration[index % max(len(robot.configuration), 1)]} leaves of its guide",
        "settling": "the time since the series' first row",
        "pose": robot.configuration[index % max(len(robot.configuration), 1)],
        "position": f"the place of P along {'xyz'[index % 3]}",
        "distance": "the distance from (" + ", ".join(f"{v:.3g}" for v in quantity.setting) + ") m",
        "clock": "the time since the first row",
        "elapsed": "the time since the series' first row",
        "started": "the time of the series' first row",
        "after": "whether the time is before or after " + "".join(f"{v:.4g} s" for v in quantity.setting),
        "warming": "the warming",
        "temperature": "the temperature",
        "warmth": "the temperature of the series' first row",
        "deflection": f"the deflection along {robot.coordinates.deflection[index % robot.coordinates.n]}",
        "carried": f"{robot.coordinates.wrench[index % robot.coordinates.n]} along the platform's axes",
        "latched": "the direction of the last force that was large enough",
        "own_gravity": f"gravity along the platform's {'xyz'[index % 3]}",
        "weight": "the size of the load",
    }
    return names.get(kind, kind)


def says(form: str, seen: Sequence[str]) -> str:
    """What a law does, and on which of what was seen it depends; the first clause alone where it is always the same."""
    shown = ", ".join(seen[:3]) + (" and others" if len(seen) > 3 else "")
    return f"{FORMS[form]} {shown}" if seen else FORMS[form].removesuffix(", depending on")


def _place(index: int, robot: Robot) -> str:
    """What the coordinate of an actuator is."""
    return "angle" if index < len(robot.stiffness) and robot.units[index] == "rad" else "length"


def _load(index: int, robot: Robot) -> str:
    """A component of the load, e.g. `the moment about x`."""
    d = len(robot.gravity)
    return f"the force along {'xyz'[index]}" if index < d else f"the moment about {'xyz'[index - d]}"


def depends_on(quantities: tuple[Quantity, ...], robot: Robot) -> list[str]:
    """Names of what a law depends on, each once."""
    return list(dict.fromkeys(quantity_name(q, robot) for q in quantities))


def identifier(quantity: Quantity, robot: Robot) -> str:
    """A quantity as files name it (file-formats.md, diagnosis.json), e.g. `length`; of whose, the component says."""
    count, kind, index = len(robot.stiffness), quantity.kind, quantity.index
    wrench = robot.coordinates.wrench
    if kind in ("effort", "effort_sign", "stop", "lag"):
        ending = {"effort_sign": "_sign", "stop": "_history", "lag": "_history"}.get(kind, "")
        own = "moment" if index < count and robot.units[index] == "rad" else "force"
        return (own if index < count else wrench[(index - count) % len(wrench)]) + ending
    if kind == "whole":
        return f"{_load(index, robot).split(' ')[1]}_{_load(index, robot)[-1]}"
    names = {
        "pair": "force_of_both",
        "pair_sign": "force_of_both_sign",
        "slip": "bending_history",
        "joint_moment": f"moment_{'xyz'[index % 3]}",
        "ground": f"{wrench[index % len(wrench)]}_about_O",
        "length": _place(index, robot),
        "rest": "load_of_reference",
        "overlap": "overlap",
        "settling": "time_in_series",
        "pose": robot.configuration[index % max(len(robot.configuration), 1)],
        "position": f"position_{'xyz'[index % 3]}",
        "clock": "time",
        "elapsed": "time_in_series",
        "started": "time",
        "after": "time",
        "warming": "temperature_change",
        "warmth": "temperature",
        "deflection": f"deflection_{robot.coordinates.deflection[index % robot.coordinates.n]}",
        "carried": f"{wrench[index % len(wrench)]}_along_platform",
        "latched": "force_history",
        "own_gravity": f"gravity_{'xyz'[index % 3]}",
        "weight": "load",
    }
    return names.get(kind, kind)


def columns(quantities: tuple[Quantity, ...], robot: Robot) -> tuple[str, ...]:
    """Columns of a curve's table, with units: `length_m`; what has one name is numbered."""
    names = [identifier(q, robot) for q in quantities]
    units = [unit_of(q, robot).replace("·", "") for q in quantities]
    found = []
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        number = f"_{names[: i + 1].count(name)}" if names.count(name) > 1 else ""
        found.append(name + number + (f"_{unit}" if unit else ""))
    return tuple(found)


def unit_of(quantity: Quantity, robot: Robot) -> str:
    """SI unit of a quantity."""
    count = len(robot.stiffness)
    if quantity.kind == "length" and quantity.index < count:
        return robot.units[quantity.index]
    if quantity.kind in ("stop", "lag", "effort"):
        first = (quantity.index - count) % robot.coordinates.n
        turns = first >= len(robot.gravity) if quantity.index >= count else robot.units[quantity.index] == "rad"
        return "N·m" if turns else "N"
    if quantity.kind in ("whole", "rest"):
        return "N·m" if quantity.index >= len(robot.gravity) else "N"
    if quantity.kind in ("pose", "deflection"):
        return "m" if quantity.index < len(robot.gravity) else "rad"
    return _UNITS.get(quantity.kind, "")


def usually(form: str) -> str:
    """What usually behaves like that."""
    return _USUAL.get(form, "")
