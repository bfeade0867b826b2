"""Checks a graph, alone and against its map. The results are findings with place and reason."""
