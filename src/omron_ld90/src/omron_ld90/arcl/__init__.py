"""ARCL, the text protocol of the LD-90 over TCP."""
