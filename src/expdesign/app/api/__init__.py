"""The functions of the package, one file each, on which the commands are built.

Each takes paths or loaded objects, and returns a typed object whose tables are pandas frames and whose `save` writes
what the command of the same name writes.
"""
