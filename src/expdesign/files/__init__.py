"""Reading and writing of the files that people and other programs meet."""
