"""Physics that a plan's recordings would not show, and what it could do at the targets: MEIR (docs/meir.md)."""
