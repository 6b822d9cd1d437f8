"""The measurement chain: from the assumed load to the instrument's reading, with physics attached to its links."""
