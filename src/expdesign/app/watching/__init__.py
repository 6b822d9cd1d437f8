"""A run that a person looks at while it goes on: a page on this machine, and the wish to end it."""
