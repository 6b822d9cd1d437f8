"""Identification and diagnosis of recordings of real machines, which lie beside the project and not in it."""
