"""The fleet in a browser: one node, one address, nothing from the internet."""
