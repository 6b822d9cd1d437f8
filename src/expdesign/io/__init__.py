"""Files, units, tables, schemas and output; knows no robot.

What the columns of recordings and points mean, and how else they are called, is in `chain/recordings/columns.py`.
"""
