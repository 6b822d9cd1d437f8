"""Physics that legs and driven joints have alike."""
