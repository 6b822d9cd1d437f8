"""Physics of single legs: their play, screws, passive joints and geometry."""
