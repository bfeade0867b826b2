"""A trajectory graph from a floor: skeleton, pruned, straightened, completed, numbered."""
