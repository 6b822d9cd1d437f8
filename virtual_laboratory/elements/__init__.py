"""The physics that can be switched on, one class each, singly or together."""

from __future__ import annotations

from .attraction import Attraction
from .base_compliance import BaseCompliance
from .cable import Cable
from .creep import Creep
from .element import Element
from .encoder_periodic_error import EncoderPeriodicError
from .friction_hysteresis import FrictionHysteresis
from .geometric_stiffness import GeometricStiffness
from .instrument_distortion import InstrumentDistortion
from .instrument_misalignment import InstrumentMisalignment
from .instrument_scale import InstrumentScale
from .joint_position_error import JointPositionError
from .leg_backlash import LegBacklash
from .leg_coupling import LegCoupling
from .leg_nonlinear_stiffness import LegNonlinearStiffness
from .load_direction_tilt import LoadDirectionTilt
from .loose_mount import LooseMount
from .outlier import Outlier
from .passive_joint_compliance import PassiveJointCompliance
from .passive_joint_stiffness import PassiveJointStiffness
from .payload_com_offset import PayloadComOffset
from .payload_mass_error import PayloadMassError
from .platform_compliance import PlatformCompliance
from .thermal_drift import ThermalDrift
from .unilateral_stop import UnilateralStop

LIBRARY: dict[str, type[Element]] = {
    element.identifier: element
    for element in (
        PayloadComOffset,
        PayloadMassError,
        LoadDirectionTilt,
        PlatformCompliance,
        BaseCompliance,
        PassiveJointCompliance,
        PassiveJointStiffness,
        LegNonlinearStiffness,
        LegBacklash,
        FrictionHysteresis,
        Creep,
        ThermalDrift,
        LegCoupling,
        GeometricStiffness,
        JointPositionError,
        InstrumentMisalignment,
        InstrumentScale,
        EncoderPeriodicError,
        Outlier,
    )
}
"""Known effects by the identifier that a diagnosis gives them."""

OUTSIDE: dict[str, type[Element]] = {
    element.identifier: element for element in (LooseMount, Cable, Attraction, UnilateralStop, InstrumentDistortion)
}
"""Effects that a diagnosis can only call `unknown`."""

__all__ = [
    "LIBRARY",
    "OUTSIDE",
    "Attraction",
    "BaseCompliance",
    "Cable",
    "Creep",
    "Element",
    "EncoderPeriodicError",
    "FrictionHysteresis",
    "GeometricStiffness",
    "InstrumentDistortion",
    "InstrumentMisalignment",
    "InstrumentScale",
    "JointPositionError",
    "LegBacklash",
    "LegCoupling",
    "LegNonlinearStiffness",
    "LoadDirectionTilt",
    "LooseMount",
    "Outlier",
    "PassiveJointCompliance",
    "PassiveJointStiffness",
    "PayloadComOffset",
    "PayloadMassError",
    "PlatformCompliance",
    "ThermalDrift",
    "UnilateralStop",
]
