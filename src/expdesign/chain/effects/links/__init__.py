"""Physics of the links of an arm."""
