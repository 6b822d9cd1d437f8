"""One port a file, found by its place: what it adds to the chain and the family of laws that it may hide."""
