"""How often laws at ports are seen where there are none, and how far probabilities of their places can be trusted."""
