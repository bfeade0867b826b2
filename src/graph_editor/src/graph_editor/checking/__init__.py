"""What is wrong with a graph, by itself and on its map: findings with place and reason."""
