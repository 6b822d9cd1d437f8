"""Physics of machines for which no effect was written, one class each."""

from __future__ import annotations

from .base_gradient import BaseGradient
from .bellows import Bellows
from .bouc_wen import BoucWen
from .dishing_plate import DishingPlate
from .dragging_mount import DraggingMount
from .drooping_payload import DroopingPayload
from .encoder_defect import EncoderDefect
from .gauge_cross_talk import GaugeCrossTalk
from .gauge_lost_motion import GaugeLostMotion
from .holding_droop import HoldingDroop
from .hose import Hose
from .interpolation_error import InterpolationError
from .law import Unlisted
from .length_scale import LengthScale
from .lifting_foot import LiftingFoot
from .load_feed_forward import LoadFeedForward
from .needle_bearing import NeedleBearing
from .opening_bolt import OpeningBolt
from .place_backlash import PlaceBacklash
from .place_friction import PlaceFriction
from .refraction import Refraction
from .rubber_base import RubberBase
from .sagging_leg import SaggingLeg
from .screw_length import ScrewLength
from .screw_wear import ScrewWear
from .seating import Seating
from .shared_supply import SharedSupply
from .sinking_floor import SinkingFloor
from .sloshing import Sloshing
from .swaying_building import SwayingBuilding
from .taut_wire import TautWire
from .warm_leg import WarmLeg
from .wind import Wind
from .worn_socket import WornSocket

UNLISTED: dict[str, type[Unlisted]] = {
    element.identifier: element
    for element in (
        BaseGradient,
        Bellows,
        BoucWen,
        DishingPlate,
        DraggingMount,
        DroopingPayload,
        EncoderDefect,
        GaugeCrossTalk,
        GaugeLostMotion,
        HoldingDroop,
        Hose,
        InterpolationError,
        LengthScale,
        LiftingFoot,
        LoadFeedForward,
        NeedleBearing,
        OpeningBolt,
        PlaceBacklash,
        PlaceFriction,
        Refraction,
        RubberBase,
        SaggingLeg,
        ScrewLength,
        ScrewWear,
        Seating,
        SharedSupply,
        SinkingFloor,
        Sloshing,
        SwayingBuilding,
        TautWire,
        WarmLeg,
        Wind,
        WornSocket,
    )
}
"""By identifier."""

__all__ = [
    "UNLISTED",
    "BaseGradient",
    "Bellows",
    "BoucWen",
    "DishingPlate",
    "DraggingMount",
    "DroopingPayload",
    "EncoderDefect",
    "GaugeCrossTalk",
    "GaugeLostMotion",
    "HoldingDroop",
    "Hose",
    "InterpolationError",
    "LengthScale",
    "LiftingFoot",
    "LoadFeedForward",
    "NeedleBearing",
    "OpeningBolt",
    "PlaceBacklash",
    "PlaceFriction",
    "Refraction",
    "RubberBase",
    "SaggingLeg",
    "ScrewLength",
    "ScrewWear",
    "Seating",
    "SharedSupply",
    "SinkingFloor",
    "Sloshing",
    "SwayingBuilding",
    "TautWire",
    "WarmLeg",
    "Wind",
    "WornSocket",
]
