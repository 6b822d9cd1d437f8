"""The physics that can be switched on, one class each, singly or together."""

from __future__ import annotations

from .element import Element
from .instrument import InstrumentDistortion, InstrumentMisalignment, InstrumentScale, Outlier
from .leg_laws import Creep, EncoderPeriodicError, FrictionHysteresis, LegBacklash, LegNonlinearStiffness, ThermalDrift
from .outside import Attraction, Cable, LooseMount, UnilateralStop
from .payload import LoadDirectionTilt, PayloadComOffset, PayloadMassError
from .structure import (
    BaseCompliance,
    GeometricStiffness,
    JointPositionError,
    LegCoupling,
    PassiveJointCompliance,
    PassiveJointStiffness,
    PlatformCompliance,
)

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
