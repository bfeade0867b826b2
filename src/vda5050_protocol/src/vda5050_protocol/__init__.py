"""The VDA 5050 protocol: its values, their JSON encoding, and the rules of the standard."""
