"""Physics that a plan's recordings would not show, and what it could do at the targets: MEIR (theory.md 21)."""
