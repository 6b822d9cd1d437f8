"""What arms conceal: play, uneven gears, stops, hoses, links and bases that bend, tools that nobody declared."""

from __future__ import annotations

import numpy as np

from ..arms import Arm, torques
from ..campaigns import JOINTS, Campaign, Wishes
from ..concealment import Concealed, Kind, chosen_leg
from .arms import Hose, Parts, Spring, Stand

LOW = np.array([-1.4, -0.8, 0.4, -1.3, -1.3, -1.5])  # rad, of the joints in campaigns
HIGH = np.array([1.4, 0.7, 1.9, 1.3, 1.3, 1.5])
_SLACK = 1e-2  # stiffness of a joint within its play, against that of the joint


def _backlash(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    joint, most = chosen_leg(torques(Stand(arm), campaign.rows), rng, reversing=True)
    stiffness = float(arm.stiffness[joint])

    def of_size(size: float) -> Parts:
        play = Spring(joint, stiffness, -size * most / stiffness / 2, size * most / stiffness / 2, from_command=True)
        return Parts(own={joint: _SLACK * stiffness}, springs=(play,))

    return Concealed((f"joint {joint + 1}",), ("joint_backlash",), 0.005, 5.0, of_size)


def _gear(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    """A strain-wave gear: soft about zero torque, stiffer beyond two knees."""
    joint, most = chosen_leg(torques(Stand(arm), campaign.rows), rng)
    stiffness, knee = float(arm.stiffness[joint]), float(rng.uniform(0.1, 0.3))

    def of_size(size: float) -> Parts:
        soft, half = stiffness / (1.0 + size), 0.5 * (stiffness - stiffness / (1.0 + size))
        ends = [share * most / soft for share in (knee, 2.0 * knee)]
        springs = tuple(Spring(joint, half, -end, end, from_command=True) for end in ends)
        return Parts(own={joint: soft}, springs=springs)

    names = ("leg_nonlinear_stiffness", "joint_backlash")
    return Concealed((f"joint {joint + 1}",), names, 0.02, 8.0, of_size)


def _stop(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    """A long buffer or spring that a joint rests against over a part of its range: positions show its push."""
    joint, _ = chosen_leg(torques(Stand(arm), campaign.rows), rng)
    at = float(np.quantile(campaign.rows[JOINTS[joint]], rng.uniform(0.4, 0.65)))

    def of_size(size: float) -> Parts:
        return Parts(springs=(Spring(joint, size * float(arm.stiffness[joint]), -10.0, at, from_command=False),))

    names = ("passive_joint_stiffness", "leg_nonlinear_stiffness")
    return Concealed((f"joint {joint + 1}",), names, 1e-6, 0.02, of_size)


def _hose(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    """A hose package or weight compensator over two joints, taut in about half of the configurations."""
    first = int(rng.choice([1, 3]))
    aside = 0.12 * float(rng.choice([-1.0, 1.0]))
    points = ((aside, 0.05, 0.05), (aside, 0.05, 0.12 if first == 1 else 0.02))
    links = (first, first + 2)
    shadow = Stand(arm, Parts(hoses=(Hose(links, points, 10.0, 1.0),)))
    lengths = []
    for command in campaign.rows[list(JOINTS)].drop_duplicates().to_numpy(dtype=float):
        shadow.rigid(command)
        lengths.append(float(shadow._data.ten_length[0]))
    slack = float(np.quantile(lengths, rng.uniform(0.3, 0.6)))

    def of_size(size: float) -> Parts:
        return Parts(hoses=(Hose(links, points, slack, size),))

    parts = ("environment", f"joint {first + 1}", f"joint {first + 2}")
    return Concealed(parts, ("passive_joint_stiffness",), 1.0, 2e4, of_size)


def _bending(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    link = int(rng.choice([1, 2]))  # the upper arm or the forearm
    stiffness = float(arm.stiffness[link])
    parts, names = (f"link {link + 1}",), ("link_compliance", "joint_compliance")
    return Concealed(parts, names, 3e-3, 5.0, lambda size: Parts(bends={link + 1: stiffness / size}))


def _tilting(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    ratios = rng.lognormal(0.0, 0.5, 3)

    def of_size(size: float) -> Parts:
        one, two, three = (float(arm.stiffness[0] / size * ratio) for ratio in ratios)
        return Parts(tilt=(one, two, three))

    return Concealed(("base",), ("base_compliance",), 3e-3, 5.0, of_size)


def _tool(arm: Arm, campaign: Campaign, rng: np.random.Generator) -> Concealed[Parts]:
    centre = (0.06 * float(rng.normal()), 0.06 * float(rng.normal()), float(rng.uniform(0.05, 0.2)))
    parts, names = ("payload", "platform"), ("payload_mass_error",)
    return Concealed(parts, names, 0.01, 8.0, lambda size: Parts(tool=(size, centre)))


KINDS: dict[str, Kind[Parts]] = {
    "joint_backlash": Kind(Wishes(series=16), _backlash),
    "gear_winding": Kind(Wishes(series=16), _gear),
    "joint_stop": Kind(Wishes("payload", series=18), _stop),
    "hose": Kind(Wishes("payload", series=18), _hose),
    "bending_link": Kind(Wishes(series=16), _bending),
    "tilting_base": Kind(Wishes(series=16), _tilting),
    "undeclared_tool": Kind(Wishes("payload", series=18), _tool),
}
