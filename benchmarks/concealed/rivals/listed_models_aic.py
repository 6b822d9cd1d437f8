"""Choice among listed parametric models by AIC."""

from __future__ import annotations

from .listed_models import solve
from .question import main

if __name__ == "__main__":
    main(lambda question: solve(question, "aic"), __doc__)
