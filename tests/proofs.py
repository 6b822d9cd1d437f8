"""Tests that are proofs: they take long, `make proof` runs them, and each says what it would catch.

A key is a file below `tests`, or the beginning of the identifier of tests in one.
"""

PROOFS = {
    "benchmarks/": "a benchmark that no longer runs, or no longer writes what it says",
    "release/": "a distribution that lacks a file",
    "studies/": "a study of the thesis with other figures",
    "virtual_laboratory/": "a laboratory that hides something else than it says",
    "acceptance/test_laboratories.py": "robots that pass and are out of tolerance more often than stated",
    "acceptance/test_verify.py::test_a_robot_whose_truth_fails": "a risk of passing beyond the stated one",
    "api/test_coverage.py": "intervals of held-out readings that cover too little or too much",
    "api/test_machine_notebook.py": "a notebook whose outputs are not today's",
    "api/test_notebook.py": "a notebook whose outputs are not today's",
    "chain/test_markers.py": "geometry of an arm that is not recovered from positions",
    "commands/test_arms.py::test_from_the_configuration_to_commands": "a break in an arm's way from plan to commands",
    "commands/test_diagnose.py::test_the_unexplained": "a mismatch that nothing explains and that gets a name",
    "commands/test_closed_loop.py": "the benchmark of the closed loop that no longer runs",
    "commands/test_written_and_read.py": "a model that one command writes and another refuses",
    "comparison/test_comparison.py": "a criterion whose best design is not the best by it",
    "compensation/test_monte_carlo.py": "predicted deviations that repeated experiments do not have",
    "compensation/test_prediction.py::test_predictions_scatter": "predicted deviations of the wrong size",
    "criteria/test_montecarlo.py": "DUIR, FEIR or total that repeated experiments do not have",
    "criteria/test_new_criterion.py::test_a_criterion_without_derivative": "a search that needs every gradient",
    "design/optimality/test_certificate.py": "a bound that a design is below",
    "design/optimality/test_deviations.py": "an allowed deviation that costs more than it says",
    "design/optimality/test_polish.py": "a front that is not optimal, or not within its limits",
    "design/optimality/test_pose_groups.py": "shared references that a search escapes",
    "design/optimality/test_regions.py": "a bound of halved boxes that a plan is below",
    "design/test_found_robot.py::test_the_prediction_holds": "criteria of a found robot that experiments do not have",
    "design/test_resolution.py::test_criteria_are_those": "a plan that is worse as written than as searched",
    "design/test_search.py::test_more_effort": "more effort that finds less",
    "diagnosis/test_arms.py::test_a_concealed_effect_is_named": "physics of an arm that gets a wrong name",
    "diagnosis/test_diagnose.py::test_what_is_no_physics": "noise that gets the name of physics",
    "diagnosis/test_foreign_cases.py::test_forty_rows": "physics that needs more rows than said",
    "diagnosis/test_foreign_cases.py::test_neither_time": "physics that needs columns it should not",
    "diagnosis/test_foreign_cases.py::test_nothing_hidden": "an alarm where nothing is hidden",
    "diagnosis/test_foreign_cases.py::test_some_axes": "physics that needs axes it should not",
    "diagnosis/test_foreign_cases.py::test_what_was_hidden_is_found[hexapod": "foreign physics that is not named",
    "diagnosis/test_next_experiment.py": "proposed series that do not decide between explanations",
    "docs/test_extending.py::test_a_new_effect_is_found": "an effect of docs/extending.md that is not found",
    "docs/test_tutorial.py": "a tutorial whose outputs are not today's",
    "elastostatics/test_arm_regressor.py::test_a_plan": "a plan of an arm that is no better than random poses",
    "identification/test_goodness.py::test_chi_squared_has_as_many": "degrees of freedom that are not counted",
    "identification/test_further.py::test_a_stand": "a drift of an arm's stand that is not followed, or costs accuracy",
    "identification/test_goodness.py::test_identify_and_diagnose_count": "two counts of the parameters of one fit",
    "identification/test_goodness.py::test_noise_as_stated": "a verdict on noise of another level than stated",
    "identification/test_goodness.py::test_identify_and_diagnose_say_the_same": "two statements of one fit",
    "identification/test_identify.py::test_intervals_cover": "intervals that do not cover the truth in 95 of 100",
    "identification/test_identify.py::test_the_scatter_of_estimates": "a covariance that estimates do not have",
    "identification/test_identify.py::test_the_tests_have_the_level": "a test of fit of another level than stated",
    "identification/test_round_trip.py::test_every_effect": "a model file that loses an effect",
    "plausibility/test_positions.py::test_commands_and_positions": "a mistake in positions that is not named",
    "ports/test_laws.py::test_the_band_covers": "a band that does not cover the true curve",
    "report/test_in_browser.py": "a page whose scripts fail in a browser",
    "report/test_watch_in_browser.py": "a live view that fails in a browser",
    "sweeps/test_sweep.py::test_a_killed_worker": "a sweep that loses what a killed worker did",
}


def proof_of(test: str) -> str | None:
    """What a test (its identifier below `tests`) would catch if it is a proof, else None."""
    return next((caught for beginning, caught in PROOFS.items() if test.startswith(beginning)), None)
