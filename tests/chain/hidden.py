"""Physics that the virtual laboratory hides: what the chain has to fit and a diagnosis has to name."""

from dataclasses import dataclass, field
from typing import Any

from scipy.spatial.transform import Rotation

from tests.chain.laboratory import STIFFNESS

BIPOD = "bipod"


@dataclass(frozen=True)
class Case:
    """What the laboratory hides, what the chain is given, and what it has to find.

    Attributes:
        element: of the laboratory.
        component: at which the physics sits.
        variant: of the effect.
        expected: parameters by their names in reports.
        robot: of configs/robots.
        noise: of which multiple of the usual deviations a diagnosis names it beside.
    """

    element: dict[str, Any]
    component: str
    variant: str = ""
    expected: dict[str, float] = field(default_factory=dict)
    robot: str = "hexapod-h1"
    noise: float = 1.0

    def __str__(self) -> str:
        parts = (self.robot, self.element["physics"], self.element.get("law", ""), self.component, self.variant)
        return " ".join(part for part in parts if part)


def same(
    element: dict[str, Any],
    component: str,
    variant: str = "",
    *names: str,
    robot: str = "hexapod-h1",
    noise: float = 1.0,
) -> Case:
    """A case whose parameters have the same names in the laboratory."""
    return Case(element, component, variant, {name: element[name] for name in names}, robot, noise)


def of_leg(physics: str, leg: int, variant: str = "", law: str = "", **parameters: float) -> Case:
    """Physics of one leg of the bipod, all of whose parameters have the same names unless it is a law."""
    element = {"physics": physics, "component": f"leg {leg}", **({"law": law} if law else {}), **parameters}
    return same(element, f"leg {leg}", variant, *(() if law else parameters), robot=BIPOD)


SOFT = [5e7, 6e7, 1e8, 2e6, 2.5e6, 3e6]
PLANE = [2.5e7, 1e8, 1e9, 1e9, 1e9, 1e9]
MOUNT = {"xx": "compliance_dx_dx_m_per_N", "zz": "compliance_dz_dz_m_per_N", "tx": "compliance_rx_rx_rad_per_Nm"}
CASES = [
    same(
        {"physics": "payload_com_offset", "com_dx_m": 0.004, "com_dy_m": -0.003, "com_dz_m": 0.005},
        "payload", "", "com_dx_m", "com_dy_m", "com_dz_m",
    ),
    same(
        {"physics": "load_direction_tilt", "tilt_x_rad": 0.01, "tilt_y_rad": -0.02},
        "payload", "", "tilt_x_rad", "tilt_y_rad",
    ),
    Case(
        {"physics": "platform_compliance", "stiffness": SOFT, "at_m": [0, 0, 0]}, "platform", "diagonal",
        {MOUNT["xx"]: 1 / 5e7, MOUNT["zz"]: 1e-8, MOUNT["tx"]: 1 / 2e6},
    ),
    Case(
        {"physics": "platform_compliance", "stiffness": SOFT, "at_m": [0.02, -0.03, 0.1]}, "platform", "full",
        {MOUNT["tx"]: 1 / 2e6, "compliance_ry_ry_rad_per_Nm": 1 / 2.5e6},
    ),
    Case(
        # Weights alone move a base down and tilt it.
        {"physics": "base_compliance", "stiffness": [5e7, 5e7, 1e8, 5e6, 5e6, 5e6], "at_m": [0, 0, 0]},
        "base", "diagonal", {MOUNT["zz"]: 1e-8, MOUNT["tx"]: 2e-7},
    ),
    Case(
        {"physics": "base_compliance", "stiffness": [5e7, 5e7, 1e8, 5e6, 4e6, 5e6], "at_m": [0.1, 0.0, -0.1]},
        "base", "full", {MOUNT["tx"]: 2e-7, "compliance_ry_ry_rad_per_Nm": 1 / 4e6},
    ),
    Case(
        {"physics": "passive_joint_compliance", "component": "leg 2", "stiffness_N_per_m": [1e6, 2e7, 2e7]},
        "leg 2", "platform", noise=0.3,
    ),
    Case(
        {
            "physics": "passive_joint_compliance", "component": "leg 2", "stiffness_N_per_m": [5e6, 2e7, 1e7],
            "end": "base", "axes": "frame",
        },
        # Only differences to the leg's own compliance can be told: xx − zz and yy − zz.
        "leg 2", "base",
        {"compliance_xx_m_per_N": 1 / 5e6 - 1e-7, "compliance_yy_m_per_N": 1 / 2e7 - 1e-7}, noise=0.1,
    ),
    same({"physics": "passive_joint_stiffness", "joint_Nm_per_rad": 500.0}, "all legs", "flexures", "joint_Nm_per_rad",
         noise=0.1),
    Case(
        {"physics": "leg_nonlinear_stiffness", "component": "leg 3", "law": "cubic", "cubic_per_m2": 3e9},
        "leg 3", "cubic", {"hardening_at_100N": 3e9 * (100 / STIFFNESS["hexapod-h1"][2]) ** 2},
    ),
    Case(
        {"physics": "leg_nonlinear_stiffness", "component": "leg 3", "law": "hertz", "contact_m_per_N23": 5e-8},
        "leg 3", "hertz", {"hertz_at_100N_m": 5e-8 * 100 ** (2 / 3)}, noise=0.3,
    ),
    Case(
        {"physics": "leg_nonlinear_stiffness", "component": "leg 3", "law": "bilinear", "relative_change": 0.2},
        "leg 3", "asymmetric", noise=0.5,
    ),
    same(
        {"physics": "leg_backlash", "component": "leg 3", "gap_m": 2e-6, "rest": "middle"}, "leg 3", "middle", "gap_m"
    ),
    same(
        {"physics": "friction_hysteresis", "component": "leg 3", "friction_N": 6.0}, "leg 3", "rigid", "friction_N"
    ),
    same(
        {"physics": "friction_hysteresis", "component": "leg 3", "friction_N": 10.0, "contact_N_per_m": 5e6},
        "leg 3", "elastic", "friction_N",
    ),
    same(
        {"physics": "creep", "component": "all legs", "creep_ratio": 0.15, "tau_s": 60.0, "applied": 0.7},
        "all legs", "", "creep_ratio", "tau_s",
    ),
    same({"physics": "thermal_drift", "component": "leg 3", "alpha_per_K": 1.2e-5}, "leg 3", "", "alpha_per_K"),
    Case(
        {"physics": "leg_coupling", "legs": [1, 2], "stiffness": [2e7, 2e7, 2e7, 1e6, 1e6, 1e6]},
        "leg 1", "shared with leg 2",
    ),
    Case(
        {"physics": "joint_position_error", "component": "leg 4", "end": "base", "dx_m": 0.01, "dy_m": -0.01,
         "dz_m": 0.005},
        "leg 4", "base", {"joint_dx_m": 0.01, "joint_dy_m": -0.01, "joint_dz_m": 0.005},
    ),
    Case(
        {"physics": "joint_position_error", "component": "leg 2", "end": "platform", "dx_m": 0.005, "dy_m": 0.005,
         "dz_m": -0.01},
        "leg 2", "platform", {"joint_dx_m": 0.005, "joint_dy_m": 0.005, "joint_dz_m": -0.01}, noise=0.3,
    ),
    Case(
        {"physics": "instrument_misalignment", "rot_x_rad": 0.02, "rot_y_rad": -0.03, "rot_z_rad": 0.05}, "instrument",
        "",
        # The laboratory's angles are those of a rotation vector.
        dict(
            zip(
                ("rot_x_rad", "rot_y_rad", "rot_z_rad"),
                Rotation.from_rotvec([0.02, -0.03, 0.05]).as_euler("xyz").tolist(),
                strict=True,
            )
        ),
    ),
    same(
        {"physics": "instrument_scale", "scale_x": 0.02, "scale_y": -0.03, "scale_z": 0.05}, "instrument", "",
        "scale_x", "scale_y", "scale_z", noise=0.3,
    ),
    same(
        {"physics": "encoder_periodic_error", "component": "leg 5", "amplitude_m": 2e-6, "pitch_m": 2e-3,
         "phase_rad": 1.0},
        "leg 5", "", "amplitude_m", "pitch_m", "phase_rad",
    ),
    same({"physics": "load_direction_tilt", "tilt_z_rad": 0.01}, "payload", "", "tilt_z_rad", robot=BIPOD),
    same({"physics": "instrument_misalignment", "rot_z_rad": 0.02}, "instrument", "", "rot_z_rad", robot=BIPOD),
    of_leg("leg_backlash", 1, "middle", gap_m=6e-6),
    of_leg("friction_hysteresis", 2, "rigid", friction_N=25.0),
    of_leg("creep", 2, creep_ratio=0.12, tau_s=120.0),
    of_leg("thermal_drift", 1, alpha_per_K=1.2e-5),
    of_leg("encoder_periodic_error", 1, amplitude_m=3e-6, pitch_m=4e-3, phase_rad=0.7),
    of_leg("leg_nonlinear_stiffness", 1, "asymmetric", "bilinear", relative_change=0.1),
    of_leg("leg_nonlinear_stiffness", 1, "cubic", "cubic", cubic_per_m2=1e8),
    Case(
        {"physics": "passive_joint_compliance", "component": "leg 2", "stiffness_N_per_m": [6e6, 5e7, 5e7],
         "axes": "frame"},
        "leg 2", "base", robot=BIPOD,
    ),
    *(
        Case({"physics": f"{part}_compliance", "stiffness": PLANE, "at_m": [0, 0, 0]}, part, "diagonal", robot=BIPOD)
        for part in ("platform", "base")
    ),
    # In the plane a scale that both axes share is a change of all compliances.
    Case({"physics": "instrument_scale", "scale_x": 0.02, "scale_y": -0.03}, "instrument", robot=BIPOD),
    Case(
        {"physics": "joint_position_error", "component": "leg 1", "dx_m": 0.02, "dy_m": -0.01}, "leg 1", "base",
        {"joint_dx_m": 0.02, "joint_dy_m": -0.01}, robot=BIPOD,
    ),
]  # fmt: skip
