"""How large left-out physics may be: one row per kind of physics and parameter, with unit and source.

A row is the standard deviation σ of a parameter over machines of this class, and MEIR lets an effect be as large as
θᵀ·diag(σ²)⁻¹·θ ≤ 1. Where machines of all sizes agree better in a ratio than in an absolute figure, the size is a
multiple of what the robot itself has (`of`). Rows marked `assumed` rest on no publication: they are to be replaced by
what is known about the machine at hand, in the configuration (`model_error.sizes`).
"""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

Of = Literal["", "actuator compliance", "pose compliance", "actuator force", "own deflection"]
"""What a size is a multiple of.

`""`: nothing, it is in the parameter's own unit. `actuator compliance`: the mean compliance of the actuators concerned.
`pose compliance`: √(D_ii·D_jj), D the compliance of the robot at the targets and i, j the axes of the parameter.
`actuator force`: the largest force in the actuators concerned at the targets. `own deflection`: the parameter at which
the effect moves the targets as much as the springs of the actuators concerned do.
"""


@dataclass(frozen=True)
class Size:
    """One row.

    Attributes:
        physics: identifier (file-formats.md, Identifiers of physics).
        parameter: names of parameters, with `*` for any characters.
        value: σ, in the parameter's unit or as a multiple.
        of: what it is a multiple of.
        source: where the value is from.
        assumed: whether no publication states it.
    """

    physics: str
    parameter: str
    value: float
    of: Of
    source: str
    assumed: bool = True


_REPEATABILITY = (
    "V. J. Kalas, PhD thesis, Montpellier 2020 (HAL tel-03154741): hexapod repeatability ±0.75 µm; a gap is no wider"
)
_TEN_PERCENT = "assumed: a part that is meant to be rigid yields a tenth as much as the actuators together"
_STRAIN_WAVE = "assumed: one minute of arc, the order that catalogues of strain-wave gears state for one turn"

SIZES: tuple[Size, ...] = (
    # Load: what a balance, a ruler and a level leave open.
    Size("payload_com_offset", "com_d?_m", 1e-3, "", "assumed: centre of mass from a drawing, 1 mm"),
    Size("payload_mass_error", "relative_mass_error", 5e-3, "",
         "assumed: weights from a gymnasium; class M3 of OIML R 111-1:2004 would be 5e-4"),
    Size("payload_mass_error", "forgotten_N", 1.0, "", "assumed: a shackle or a plate of 0.1 kg"),
    Size("payload_mass_error", "disc_error_N", 1.0, "", "assumed: as for what was forgotten"),
    Size("payload_mass_error", "tool_mass_kg", 0.1, "", "assumed: a cable or an adapter of 0.1 kg that no drawing has"),
    Size("payload_mass_error", "tool_moment_?_kgm", 0.01, "", "assumed: the same at 0.1 m"),
    Size("load_direction_tilt", "tilt_?_rad", 5e-4, "", "assumed: a machinist's level, 0.5 mm/m"),
    # Structure.
    Size("platform_compliance", "compliance_*", 0.1, "pose compliance", _TEN_PERCENT),
    Size("base_compliance", "compliance_*", 0.1, "pose compliance", _TEN_PERCENT),
    Size("base_compliance", "beyond_*", 1e-7, "", "assumed: a foot that lifts, 0.1 µrad/(N·m)"),
    Size("base_compliance", "cubic_*", 1e-6, "", "assumed: rubber feet, 1 µm under 100 N, 1 µrad under 100 N·m"),
    Size("passive_joint_compliance", "compliance_*", 0.2, "actuator compliance",
         "assumed: a fifth of the leg's own compliance, which includes the mean of its joints"),
    Size("passive_joint_stiffness", "joint_Nm_per_rad", 50.0, "",
         "assumed: flexures or preloaded universal joints that turn by 1° under 1 N·m"),
    Size("leg_coupling", "coupling_m_per_N", 0.05, "actuator compliance", "assumed: mounts that two legs share"),
    Size("link_compliance", "*_rad_per_Nm", 0.1, "actuator compliance", _TEN_PERCENT),
    Size("joint_compliance", "*lateral*_rad_per_Nm", 0.2, "actuator compliance",
         "assumed: a bearing is five times as stiff off the axis as the gear is about it"),
    Size("joint_compliance", "lateral_change_rad_per_Nm_m", 0.2, "actuator compliance",
         "assumed: over a metre of travel a guide's bearing loses what it has off the axis"),
    Size("geometric_stiffness", "fraction", 1.0, "", "mechanics itself: the whole of the conservative term", False),
    # Actuators.
    Size("leg_nonlinear_stiffness", "*", 0.1, "own deflection",
         "assumed: secant and tangent differ by a tenth at the targets' loads"),
    Size("leg_backlash", "gap_m", 1.5e-6, "", _REPEATABILITY, False),
    Size("joint_backlash", "gap_rad", 3e-4, "", _STRAIN_WAVE),
    Size("joint_backlash", "gap_m", 1e-5, "", "assumed: linear axis without preload"),
    Size("joint_backlash", "gap_change", 1e-4, "", "assumed: a guide that is worn over a part of its travel"),
    Size("friction_hysteresis", "behind_*", 1e-7, "", "assumed: friction holds a tenth of what soft feet yield"),
    Size("friction_hysteresis", "friction_N*", 0.05, "actuator force", "assumed: a twentieth of the largest force"),
    Size("creep", "creep_ratio", 0.02, "", "assumed: greased rolling contacts, 2 % within the time of a series"),
    Size("creep", "creep_*_per_*", 0.02, "pose compliance", "assumed: 2 % of the machine's compliance"),
    Size("creep", "settled_d*_m", 1e-5, "", "assumed: tyres and rubber feet give way by 10 µm"),
    Size("creep", "settled_dr*_rad", 1e-5, "", "assumed: tyres and rubber feet give way by 10 µrad"),
    Size("creep", "unsettled_*fraction", 0.02, "", "assumed: read when 98 % of a move have settled"),
    Size("encoder_periodic_error", "*sine_m", 1e-6, "",
         "assumed: half of what a precision screw varies within a turn (some µm, ISO 3408-3)"),
    Size("encoder_periodic_error", "*sine_rad", 1.5e-4, "", _STRAIN_WAVE),
    # Geometry.
    Size("joint_position_error", "joint_d?_m", 1e-4, "", "assumed: machined and assembled to 0.1 mm, not calibrated"),
    Size("joint_position_error", "base_*_m", 1e-4, "", "assumed: machined and assembled to 0.1 mm, not calibrated"),
    Size("joint_position_error", "platform_*_m", 1e-4, "", "assumed: machined and assembled to 0.1 mm, not calibrated"),
    Size("joint_position_error", "leg_*_length_m", 1e-4, "", "assumed: legs zeroed to 0.1 mm"),
    Size("joint_position_error", "link_*_r?_rad", 1e-3, "", "assumed: castings machined to 1 mrad, not calibrated"),
    Size("joint_position_error", "link_*_m", 5e-4, "", "assumed: castings machined to 0.5 mm, not calibrated"),
    Size("joint_position_error", "frame_?_m", 5e-4, "", "assumed: castings machined to 0.5 mm, not calibrated"),
    Size("joint_position_error", "frame_r?_rad", 1e-3, "", "assumed: castings machined to 1 mrad, not calibrated"),
    Size("joint_position_error", "*offset*", 2e-3, "", "assumed: zeros set by marks, 2 mrad or 2 mm"),
    Size("joint_position_error", "joint_*", 2e-3, "", "assumed: zeros set by marks, 2 mrad or 2 mm"),
    # Instrument and surroundings.
    Size("instrument_misalignment", "rot_?_rad", 1e-3, "", "assumed: axes aligned with an edge, 1 mrad"),
    Size("instrument_scale", "scale_?", 1e-3, "", "assumed: gauges calibrated to 0.1 % of their range"),
    Size("thermal_drift", "alpha_per_K", 1.2e-5, "", "EN 1993-1-1:2005, 3.2.6: steel, 12e-6 per kelvin", False),
    Size("thermal_drift", "rate_per_s", 1.2e-8, "", "assumed: steel that warms by 1 K in 1000 s"),
    Size("thermal_drift", "d?_m_per_K", 1e-6, "", "assumed: a stand of 0.1 m of steel"),
    Size("thermal_drift", "dr?_rad_per_K", 1e-6, "", "assumed: 1 µm over 1 m"),
    Size("thermal_drift", "d?_m_per_s", 1e-9, "", "assumed: 1 K in 1000 s"),
    Size("thermal_drift", "dr?_rad_per_s", 1e-9, "", "assumed: 1 K in 1000 s"),
    Size("thermal_drift", "drift_r?_rad_per_h", 1e-5, "", "assumed: a stand of 0.1 m that warms by 1 K on one side"),
    Size("thermal_drift", "drift_?_m_per_h", 1e-5, "", "assumed: a stand of 1 m of steel that warms by 1 K in an hour"),
    Size("thermal_drift", "drift_m_per_K", 5e-6, "", "assumed: a linear axis of 0.4 m of steel"),
    Size("thermal_drift", "drift_m_per_s", 5e-9, "", "assumed: 1 K in 1000 s"),
    Size("thermal_drift", "drift_m", 5e-5, "", "assumed: warming up by 10 K"),
    Size("thermal_drift", "drift_rad_per_K", 1e-5, "", "assumed: a joint's housing"),
    Size("thermal_drift", "drift_rad_per_s", 1e-8, "", "assumed: 1 K in 1000 s"),
    Size("thermal_drift", "drift_rad", 1e-4, "", "assumed: warming up by 10 K"),
)  # fmt: skip


def size_of(physics: str, parameter: str, sizes: tuple[Size, ...] = SIZES) -> Size | None:
    """The first row for a parameter, or None."""
    for size in sizes:
        if size.physics == physics and fnmatchcase(parameter, size.parameter):
            return size
    return None
