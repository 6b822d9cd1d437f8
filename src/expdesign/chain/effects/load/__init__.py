"""The load is not the assumed one."""
