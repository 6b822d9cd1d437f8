"""Effects of the structure beside the actuators."""
