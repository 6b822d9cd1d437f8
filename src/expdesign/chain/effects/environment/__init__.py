"""What surrounds the robot."""
