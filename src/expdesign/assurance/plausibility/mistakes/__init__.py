"""Mistakes that people make in recordings of deflections: how these would have to be read, or what gives it away."""

from collections.abc import Callable, Iterator

from expdesign.assurance.plausibility.evidence import Alternative, Evidence
from expdesign.assurance.plausibility.finding import Implausibility
from expdesign.assurance.plausibility.mistakes import columns, numbers, rows

ALTERNATIVES: tuple[Callable[[Evidence], Iterator[Alternative]], ...] = (
    columns.signs_of_readings,
    columns.units_of_readings,
    columns.swapped_readings,
    columns.moments,
    columns.units_of_commands,
    columns.swapped_loads,
    columns.swapped_commands,
    rows.slipped_reading,
    rows.slipped_load,
    rows.exchanged_rows,
    rows.shifted_rows,
    columns.instrument_frame,
    columns.load_frame,
    columns.gravity,
    columns.angle_order,
)
"""Other readings of the same recordings; all compete, and of equals the first is named."""
FINDINGS: tuple[Callable[[Evidence], Iterator[Implausibility]], ...] = (
    numbers.stiffness_factor,
    numbers.scatter,
    numbers.without_reading,
    numbers.copied_rows,
    numbers.rounded,
    numbers.constant,
)
"""What gives a mistake away without a comparison, in the order in which it is said."""
