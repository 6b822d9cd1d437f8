"""What makes new designs out of known ones, one file each (`operator.py` has the protocol)."""
