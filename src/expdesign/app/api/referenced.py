"""Which rows share an unloaded reading, decided once for what is computed of recordings."""

from expdesign.assurance.plausibility.finding import Finding, say
from expdesign.chain.recordings.references import Points, Sharing, with_references
from expdesign.planning.problem import DesignProblem


def referenced(points: Points, option: bool | None, problem: DesignProblem | None = None) -> Points:
    """The points with their references; contradictions are logged as warnings (`chain/recordings/references.py`).

    Args:
        points: recordings, or a check measurement's points.
        option: what the caller says, which overrides; None where nothing is said.
        problem: of the configuration that is given with them.
    """
    configured = None if problem is None else problem.noise.shared_reference
    source = "" if problem is None else problem.source
    found, contradictions = with_references(points, Sharing(option, configured, source))
    say([Finding(one.what, one.holds, "shared references") for one in contradictions], points.source)
    return found
