"""Searches for physics that may be named: within the limits of what is possible, and apart from what it imitates.

An effect that a fit has driven to its limit describes something else, and is not a name. A drift that shows only
because something else changed with time (`confounded_time`) is not one either. Both are withdrawn from the library, and
the search goes on without them; most of its models are known by then.
"""

from collections.abc import Callable
from dataclasses import dataclass

from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.confounded_time import confounded_with, drift_tests, unsupported
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.names import NamedModel
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.remarks import ConfoundedTime
from expdesign.diagnosis.verdict import at_limits

_ROUNDS = 8
"""Of searches after physics was withdrawn."""


@dataclass(frozen=True)
class Nameable:
    """A model whose effects may be named.

    Attributes:
        model: the model.
        at_limit: of a better model that physics at its limit would give, the parameter; empty where there is none.
        remarks: what the search had to leave open.
    """

    model: NamedModel
    at_limit: str
    remarks: tuple[Remark, ...]


def nameable(
    search: Search,
    *,
    outliers: bool = True,
    most: int | None = None,
    in_vain: Callable[[NamedModel], bool] = lambda model: False,
) -> Nameable:
    """The best model without physics at its limits and without drifts that imitate.

    Args:
        search: for named effects.
        outliers: whether rows may be set aside.
        most: effects that are looked for at most.
        in_vain: whether a model explains too little for others to be looked for without what has to be withdrawn.
    """
    names = search.known_names
    other = confounded_with(names.sample, names.robot)
    imitations: list[str] = []
    limited: tuple[float, str] | None = None
    for _ in range(_ROUNDS):
        model = search.model(aside=outliers, most=most)
        limits = at_limits(model, names.reach)
        drifts = unsupported(names, model, other)
        if not limits and not drifts:
            break
        vain = in_vain(model)
        for key, parameter in limits.items():
            names.log.add("limits", model, False, f"{parameter} is at or beyond the limit of what a machine can be")
            limited = min(limited or (model.misfit, parameter), (model.misfit, parameter))
            names.forbid({key})
        for key in drifts:
            names.log.add("drift", model, False, f"`{key}` does not show apart from what changed with time")
            names.forbid({key})
            imitations.append(key)
        if vain:
            model = names.restricted(model, {*limits, *drifts})
            break
    else:
        model = search.model(aside=outliers, most=most)
        model = names.restricted(model, {*at_limits(model, names.reach), *unsupported(names, model, other)})
    at_limit = limited[1] if limited is not None and limited[0] < model.misfit - 2.0 * OPTIONS.alarm else ""
    remarks: tuple[Remark, ...] = ()
    if other is not None and (imitations or drift_tests(names, model, other)):
        remarks = (ConfoundedTime(other.name, other.share, tuple(imitations)),)
    return Nameable(model, at_limit, remarks)
