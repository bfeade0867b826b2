"""Shows the fleet in a browser. It is one node with one address, and needs no internet."""
