"""Physics of the joints of an arm."""
