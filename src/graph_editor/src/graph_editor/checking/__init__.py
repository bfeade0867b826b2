"""Checks a graph by itself and on its map; the results are findings with place and reason."""
