"""What to measure: criteria, the space of designs and its constraints, the search, bounds, what to measure next."""
