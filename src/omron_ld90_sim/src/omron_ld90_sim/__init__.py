"""A simulated OMRON LD-90 that speaks ARCL."""
