"""The mistakes that people make in recordings of deflections, one class each; of equals the first is named."""

from expdesign.assurance.plausibility.mistakes.columns import SwappedCommands, SwappedLoads, SwappedReadings
from expdesign.assurance.plausibility.mistakes.deviations import Scatter, WithoutReading
from expdesign.assurance.plausibility.mistakes.frames import AngleOrder, Gravity, LoadFrame, WrongInstrumentFrame
from expdesign.assurance.plausibility.mistakes.mistake import Mistake
from expdesign.assurance.plausibility.mistakes.moments import Moments
from expdesign.assurance.plausibility.mistakes.numbers import Constant, CopiedRows, Rounded
from expdesign.assurance.plausibility.mistakes.rows import ExchangedRows, ShiftedRows
from expdesign.assurance.plausibility.mistakes.signs import TurnedSigns
from expdesign.assurance.plausibility.mistakes.slips import SlippedLoad, SlippedReading
from expdesign.assurance.plausibility.mistakes.stiffness import StiffnessFactor
from expdesign.assurance.plausibility.mistakes.units import CommandUnits, ReadingUnits

MISTAKES: tuple[Mistake, ...] = (
    TurnedSigns(),
    ReadingUnits(),
    SwappedReadings(),
    Moments(),
    CommandUnits(),
    SwappedLoads(),
    SwappedCommands(),
    SlippedReading(),
    SlippedLoad(),
    ExchangedRows(),
    ShiftedRows(),
    WrongInstrumentFrame(),
    LoadFrame(),
    Gravity(),
    AngleOrder(),
    StiffnessFactor(),
    Scatter(),
    WithoutReading(),
    CopiedRows(),
    Rounded(),
    Constant(),
)
"""In the order in which they are asked."""

__all__ = ["MISTAKES", "Mistake"]
