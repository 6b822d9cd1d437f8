"""Monte-Carlo of the whole method: draw errors, identify, compensate exactly, and look at what is attained."""
