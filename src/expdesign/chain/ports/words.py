"""Kinds of laws in words that a technician understands: what they do, on what, and what usually behaves like that."""

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
    "approach": "stops short of its command, depending on",
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
USUALLY = {
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
    "approach": "a dead band of its control, play and friction in its drive do that",
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
"""What usually does that."""


def says(form: str, seen: Sequence[str]) -> str:
    """What a law does, and on which of what was seen it depends; the first clause alone where it is always the same."""
    shown = ", ".join(seen[:3]) + (" and others" if len(seen) > 3 else "")
    return f"{FORMS[form]} {shown}" if seen else FORMS[form].removesuffix(", depending on")


def depends_on(quantities: tuple[Quantity, ...], robot: Robot) -> list[str]:
    """Names of what a law depends on, each once."""
    return list(dict.fromkeys(q.name(robot) for q in quantities))


def columns(quantities: tuple[Quantity, ...], robot: Robot) -> tuple[str, ...]:
    """Columns of a curve's table, with units: `length_m`; what has one name is numbered."""
    names = [q.identifier(robot) for q in quantities]
    units = [q.unit(robot).replace("·", "") for q in quantities]
    found = []
    for i, (name, unit) in enumerate(zip(names, units, strict=True)):
        number = f"_{names[: i + 1].count(name)}" if names.count(name) > 1 else ""
        found.append(name + number + (f"_{unit}" if unit else ""))
    return tuple(found)
