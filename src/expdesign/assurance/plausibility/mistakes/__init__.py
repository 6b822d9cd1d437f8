"""The mistakes that people make in recordings of deflections, one class each; of equals the first is named."""

from expdesign.assurance.plausibility.mistakes.exchanged import (
    ExchangedRows,
    ShiftedRows,
    SwappedCommands,
    SwappedLoads,
    SwappedReadings,
)
from expdesign.assurance.plausibility.mistakes.frames import AngleOrder, Gravity, LoadFrame, WrongInstrumentFrame
from expdesign.assurance.plausibility.mistakes.mistake import Mistake
from expdesign.assurance.plausibility.mistakes.numbers import (
    Constant,
    CopiedRows,
    Rounded,
    Scatter,
    SlippedLoad,
    SlippedReading,
    WithoutReading,
)
from expdesign.assurance.plausibility.mistakes.scaled import (
    CommandUnits,
    Moments,
    ReadingUnits,
    StiffnessFactor,
    TurnedSigns,
)

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
