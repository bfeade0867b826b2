"""Shows the fleet in a browser. It is one node at one address, and it needs no internet."""
