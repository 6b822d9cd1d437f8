"""Whether results can be relied on: acceptance, verification, plausibility, Monte-Carlo, comparison, model error."""
