"""What physics says of the input: impossible is an error, suspicious a warning that names the likely unit or sign.

Every file holds the checks of one kind of input. Thresholds lie far outside what machines and laboratories have, so
that a sound input is never warned of.
"""
