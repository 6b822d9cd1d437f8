"""The words of the pages, for a reader who has not met them; each page names those that it uses."""

from expdesign.report.blocks import Definitions, PageSection

_WORDS = {
    "Deflection": "How far the platform or tip moves when the load is put on, at the same command of the actuators.",
    "Tolerance": "The error that the configuration accepts on an axis of a target. 1 tolerance = just acceptable.",
    "RMS, σ": "Root mean square error, one standard deviation: two of three outcomes lie within it.",
    "DUIR": "RMS error at the targets after calibration, due to noise of the measured deflections.",
    "FEIR": "RMS error at the targets, due to errors of the applied loads in the experiment.",
    "total": "The RMS error to expect at the targets after calibration and compensation, from both.",
    "MEIR": "The error at the targets that physics beyond the model still causes where the plan does not show it.",
    "O1 to O5": "Observability indices: how well all stiffnesses are determined, regardless of the targets. Larger is "
    "better.",
    "O_TP, O_MV": "Variance of the attained position due to noise: at the first target, and over the targets (m²).",
    "Front": "Designs that no other design beats in every objective.",
    "Recommended": "The design with the least total error of those expected to pass, or of all where none is.",
    "Knee": "The design nearest to the ideal point, with objectives scaled over the front.",
    "Hypervolume": "Volume of the space of objectives that the front dominates; it grows as the search improves.",
    "Design by X": "The plan that is best by criterion X alone, as its own author would choose it, of all that were "
    "found: searched for every criterion, then refined along its gradient to a local optimum.",
    "Attained": "What is left at the targets after experiment, identification and exact compensation, repeated with "
    "noise and load errors drawn anew: RMS over the repetitions, in tolerances. Every design meets the same draws.",
    "Rank correlation": "Spearman's: whether two quantities put designs in the same order, from −1 to 1.",
    "Random designs": "Measurements drawn evenly from all that the robot can reach.",
    "Stiffness": "Force in an actuator per change of its length; the base model is one spring per actuator.",
    "Base model": "One linear spring per actuator and nothing else.",
    "95 % interval": "Covers the true value in 95 of 100 repetitions of the experiment, if the model holds. A "
    "stiffness' interval is the inverse of its compliance's, and so is not symmetric.",
    "Standard deviation": "Size of the noise of a reading (σ); residuals divided by it scatter with RMS 1.",
    "Replicates": "Rows with the same command under the same load; their scatter is noise and nothing else.",
    "Held out": "Recordings that a model has not seen when it was fitted; what it says about them is a prediction.",
    "Probability": "That this physics at this component is really there, given these recordings and the library of "
    "physics that was searched.",
    "Repetition": "Errors are drawn, the plan is measured, stiffness identified, and every target compensated.",
    "z": "How many standard errors of the simulation lie between simulation and prediction; mostly within ±2.",
    "Mean error": "Average of attained minus wanted pose; noise and load errors average out, neglected physics not.",
}


def words_section(*names: str) -> PageSection:
    """The section that says what words mean."""
    return PageSection("words", "What the words mean", [Definitions([(name, _WORDS[name]) for name in names])])
