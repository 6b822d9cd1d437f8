"""Choice among listed parametric models by BIC."""

from __future__ import annotations

from .listed_models import solve
from .question import main

if __name__ == "__main__":
    main(lambda question: solve(question, "bic"), __doc__)
