"""The mistakes that people make in recordings of deflections, one class each; of equals the first is named."""

from expdesign.plausibility.mistakes.columns import SwappedCommands, SwappedLoads, SwappedReadings
from expdesign.plausibility.mistakes.deviations import Scatter, WithoutReading
from expdesign.plausibility.mistakes.frames import AngleOrder, Gravity, InstrumentFrame, LoadFrame
from expdesign.plausibility.mistakes.mistake import Mistake
from expdesign.plausibility.mistakes.moments import Moments
from expdesign.plausibility.mistakes.numbers import Constant, CopiedRows, Rounded
from expdesign.plausibility.mistakes.rows import ExchangedRows, ShiftedRows
from expdesign.plausibility.mistakes.signs import TurnedSigns
from expdesign.plausibility.mistakes.slips import SlippedLoad, SlippedReading
from expdesign.plausibility.mistakes.stiffness import StiffnessFactor
from expdesign.plausibility.mistakes.units import CommandUnits, ReadingUnits

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
    InstrumentFrame(),
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
