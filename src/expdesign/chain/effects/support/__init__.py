"""What a body stands on."""
