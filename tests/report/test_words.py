"""Numbers and names as people read them."""

import math

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.remarks import Averaged
from expdesign.report import words
from expdesign.report.physics_words import effect_words
from expdesign.report.remark_texts import TEXTS, sentence
from expdesign.report.stiffness import stiffness_table
from tests.cases import robot


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (0.0494029, "0.0494"),
        (9.999, "10.0"),
        (99999.0, "1.00\u202f·\u202f10⁵"),
        (-12.34, "−12.3"),
        (2.697e-14, "2.70\u202f·\u202f10⁻¹⁴"),
        (math.nan, "not determined"),
        (math.inf, "∞"),
    ],
)
def test_number(value: float, text: str) -> None:
    assert words.number(value) == text


def test_beside_what_is_large_rounding_is_zero() -> None:
    """A million-millionth of a micrometre beside a tenth of one is what the computation rounds, and nothing else."""
    assert words.number(1e-12, scale=0.1) == "0"
    assert words.number(-3e-13, scale=0.1) == "0"
    assert words.number(2e-7, scale=0.1) == "2.00\u202f·\u202f10⁻⁷"
    assert words.number(1e-12) == "1.00\u202f·\u202f10⁻¹²"
    assert words.number(0.0, scale=0.1) == "0"


def test_angles_of_joints_are_in_degrees() -> None:
    column = words.plan_column("q3_rad")
    assert (column.title, column.unit) == ("q3", "°")
    assert column.factor * math.pi == pytest.approx(180.0)
    assert words.plan_column("q2_m").unit == "mm"
    assert words.plan_column("rx_rad").unit == "mrad"


def test_a_value_with_its_error() -> None:
    assert words.with_error(0.52205, 0.00058) == "0.52205 ± 0.00058"
    assert words.with_error(-12.345, 2.0) == "−12.3 ± 2.0"
    assert words.with_error(1234.5, 240.0) == "1234 ± 240"  # half to even
    assert words.with_error(2.0, 0.0) == "2.00"


def test_a_fixed_number_has_no_negative_zero() -> None:
    assert words.fixed(-0.0001, 3) == "0.000"
    assert words.fixed(-27.6789, 3) == "−27.679"


def test_counts() -> None:
    assert words.count(1, "target") == "one target"
    assert words.count(6, "measurement") == "six measurements"
    assert words.count(120, "design") == "120 designs"


@pytest.mark.parametrize(
    ("column", "title", "unit", "factor"),
    [
        ("rx_rad", "rx", "mrad", 1e3),
        ("com_x_m", "centre of mass x", "mm", 1e3),
        ("mx_Nm", "mx", "N·m", 1.0),
        ("gz_m_s2", "gz", "m/s²", 1.0),
        ("series", "series", "", 1.0),
    ],
)
def test_columns_of_a_plan(column: str, title: str, unit: str, factor: float) -> None:
    assert words.plan_column(column) == words.Column(title, unit, factor)


def test_axes() -> None:
    assert (words.axis("drx_rad"), words.micro_unit("drx_rad")) == ("drx", "µrad")
    assert (words.axis("dz_m"), words.micro_unit("dz_m")) == ("dz", "µm")


@pytest.mark.parametrize(
    ("name", "size", "title", "unit", "factor"),
    [
        ("gap_m", 1e-6, "gap", "µm", 1e6),
        ("pitch_m", 2e-3, "pitch", "mm", 1e3),
        ("tilt_x_rad", 1e-2, "tilt x", "mrad", 1e3),
        ("com_dx_m", 1e-2, "centre of mass dx", "mm", 1e3),
        ("beyond_rx_rad_per_Nm", 1e-8, "beyond rx", "rad/(N·m)", 1.0),
        ("joint_Nm_per_rad", 3.0, "joint", "N·m/rad", 1.0),
        ("relative_mass_error", 0.01, "relative mass error", "", 1.0),
    ],
)
def test_parameters_are_shown_in_units_of_their_size(
    name: str, size: float, title: str, unit: str, factor: float
) -> None:
    assert words.parameter(name, size) == words.Column(title, unit, factor)


def test_stiffness_is_shown_in_newtons_per_micrometre() -> None:
    assert words.stiffness("N/m") == ("N/µm", "µm/N", 1e-6)
    assert words.stiffness("N·m/rad")[2] == 1.0
    assert words.listed(["a"]) == "a"
    assert words.listed(["a", "b", "c"]) == "a, b and c"
    assert words.sentence("five rows") == "Five rows"


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("encoder_periodic_error / leg 3", "error of a command that repeats with screw or gear (leg 3)"),
        ("encoder_periodic_error / all joints", "errors of joints that repeat with every turn (all joints)"),
        ("leg_backlash / leg 4 / long", "play of a leg (leg 4, long)"),
        ("law", "law"),
    ],
)
def test_physics_is_called_what_it_is_at_its_component(key: str, text: str) -> None:
    assert effect_words(key) == text


@pytest.mark.parametrize(
    ("estimate", "low", "high", "said"),
    [
        (2e7, 1.9e7, 2.1e7, "leg 1 20.00 19.00 21.00"),
        (3e12, 1.9e7, np.inf, "leg 1 not determined 19.00 ∞"),
        (-9.6e6, 2.2e7, np.inf, "leg 1 not determined 22.00 ∞"),
        (-9.6e6, np.inf, np.inf, "leg 1 not determined ∞ ∞"),
    ],
)
def test_a_compliance_that_may_be_zero_has_a_least_stiffness_alone(
    estimate: float, low: float, high: float, said: str
) -> None:
    hexapod = robot("H1")
    frame = pd.DataFrame({"actuator": hexapod.actuators, "stiffness": estimate, "low": low, "high": high})
    assert " ".join(stiffness_table(frame, hexapod, "").lines[1].split()) == said


def test_every_remark_has_a_sentence_of_its_own() -> None:
    assert set(TEXTS) == set(Remark.__subclasses__())


def test_an_average_over_what_may_be_there_says_nothing_of_missing_physics() -> None:
    """The verdict beside it may be `consistent`."""
    text = sentence(Averaged(6, ("creep / leg 1",)))
    assert "too few to rule out small effects" in text
    assert "missing" not in text
