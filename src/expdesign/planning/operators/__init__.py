"""What makes new designs out of known ones, one file each (`state.py` has the protocol)."""
