"""What left-out physics is called in sentences: "a soft platform", "play in leg 3"."""

from expdesign.model_error.hidden_physics import HiddenPhysics


def sentence(worst: HiddenPhysics, freedom: int, readings: str) -> str:
    """What a plan or recordings hide, for people.

    Args:
        worst: of all effects.
        freedom: degrees of freedom of the residuals.
        readings: what would have to show it: `this plan`, `these recordings`.
    """
    if freedom == 0:
        return (
            f"With as many readings as unknowns nothing that the model leaves out could be noticed by {readings}: "
            f"{worst.phrase} of the size that is assumed would cost {worst.error:.3g} tolerances at the targets."
        )
    text = f"{worst.phrase[0].upper()}{worst.phrase[1:]} could cost {worst.error:.3g} tolerances at the targets"
    if worst.limited_by == "detection":
        return f"{text} before {readings} would show it."
    if worst.noticed == float("inf"):
        return f"{text} at the size that is assumed, and {readings} would not show it at all."
    return f"{text} at the size that is assumed; {readings} would show it from {worst.noticed:.3g} times that size on."
