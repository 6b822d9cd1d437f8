"""Physics that an independent engine hides is named at its component, with its parameters."""

import numpy as np
import pytest

from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.coverage import NORMAL_95
from tests.chain.hidden import CASES, Case
from tests.chain.laboratory import DEVIATION, experiment, machine, measured
from tests.identification.experiments import read

ROWS = {"bipod": experiment("bipod", 16, 5), "hexapod-h1": experiment("hexapod-h1", 12, 5)}


def diagnosed(case: Case) -> Diagnosis:
    """What is said of recordings with noise, whose size the case chooses, of which the last quarter is held out."""
    columns = machine(case.robot).coordinates
    frame = measured(case.robot, case.element, rows=ROWS[case.robot])
    deviations = case.noise * np.array(DEVIATION[case.robot])
    frame[list(columns.deviation)] = deviations
    shape = (len(frame), len(deviations))
    frame[list(columns.deflection)] += np.random.default_rng(3).standard_normal(shape) * deviations
    return diagnose(machine(case.robot), read(frame, machine(case.robot)))


def places(case: Case) -> tuple[str, ...]:
    """Components at which it may be named: what two legs share is of either."""
    return (case.component, case.variant.removeprefix("shared with "))


def intervals(case: Case, finding: Finding) -> dict[str, tuple[float, float]]:
    """Estimates of the parameters with half of their 95 % intervals, of the physics that was hidden.

    Of two explanations that the recordings do not tell apart either may be first. Then it is said that they are not
    told apart, neither is likelier than not, and what was hidden is the explanation that is kept beside the first.
    """
    physics = case.element["physics"]
    if finding.physics == physics:
        assert finding.component in places(case)
        return {name: (found[0], 0.5 * (found[2] - found[1])) for name, found in finding.parameters.items()}
    assert physics in finding.indistinguishable
    assert finding.probability <= 0.5
    assert finding.rival is not None
    (other,) = finding.rival.effects
    assert other.physics == physics
    assert str(other.component) in places(case)
    fit, at = finding.rival.fit, finding.rival.fit.chain.slices[0]
    deviations = np.sqrt(np.diag(fit.covariance)[at])
    names = [parameter.name for parameter in other.parameters]
    return {n: (v, NORMAL_95 * d) for n, v, d in zip(names, fit.values[at], deviations, strict=True)}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_what_was_hidden_is_named(case: Case) -> None:
    """The truth lies in the 95 % interval widened to 99.99 %; a law of another form has parameters of its own."""
    result = diagnosed(case)
    assert result.verdict == "explained"
    (finding,) = result.findings
    found = intervals(case, finding)
    for name in case.expected.keys() & found.keys():
        estimate, half = found[name]
        assert abs(estimate - case.expected[name]) <= 2.0 * half, name
    assert result.before.refuted
    assert not result.after.refuted
    assert result.errors.test_after < result.errors.test_before
