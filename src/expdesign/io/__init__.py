"""Files, units, tables, schemas and output; knows no robot."""
