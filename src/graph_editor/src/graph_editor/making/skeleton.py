"""Makes the skeleton of a mask: forks and ends become nodes; cells between nodes become chains."""
from __future__ import annotations

from typing import Dict, Iterator, List, Tuple

import numpy as np
from scipy import ndimage
from skimage.morphology import skeletonize

from graph_editor.floor import EVERY_NEIGHBOUR, Floor
from graph_editor.making.chains import ChainGraph

Cell = Tuple[int, int]
_AROUND = ((-1, 0), (0, -1), (0, 1), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


def skeleton_of(floor: Floor, mask: np.ndarray) -> ChainGraph:
    """Returns the skeleton of `mask`, a part of the floor.

    A connected part without forks and ends gets one node.
    """
    skeleton = skeletonize(mask)
    neighbours = ndimage.convolve(skeleton.astype(np.uint8), np.ones((3, 3), np.uint8),
                                  mode='constant') - 1
    knots = skeleton & (neighbours != 2)
    _add_knots_to_rings(skeleton, knots)
    clusters, count = ndimage.label(knots, EVERY_NEIGHBOUR)
    graph = ChainGraph(floor)
    for node, cell in enumerate(_middles(clusters, count), 1):
        graph.add_node(node, _centres(floor, [cell])[0])
    for start, end, cells in _chains(skeleton, clusters):
        graph.add_chain(start, end, np.vstack((
            graph.position(start), _centres(floor, cells), graph.position(end))))
    return graph


def _centres(floor: Floor, cells: List[Cell]) -> np.ndarray:
    rows, columns = np.array(cells, int).T
    return floor.centres(rows, columns)


def _add_knots_to_rings(skeleton: np.ndarray, knots: np.ndarray) -> None:
    """Adds a knot to each closed chain that has none, at the chain's first cell."""
    parts, _ = ndimage.label(skeleton, EVERY_NEIGHBOUR)
    with_knot = set(np.unique(parts[knots]).tolist())
    for part, window in enumerate(ndimage.find_objects(parts), 1):
        if part not in with_knot:
            rows, columns = np.nonzero(parts[window] == part)
            knots[rows[0] + window[0].start, columns[0] + window[1].start] = True


def _middles(clusters: np.ndarray, count: int) -> Iterator[Cell]:
    """Yields for each cluster the cell that is nearest to the cluster's centroid."""
    rows, columns = np.nonzero(clusters)
    labels = clusters[rows, columns]
    order = np.argsort(labels, kind='stable')
    cells = np.column_stack((rows, columns))[order]
    for cluster in np.split(cells, np.cumsum(np.bincount(labels, minlength=count + 1)[1:-1])):
        nearest = int(np.argmin(((cluster - cluster.mean(axis=0)) ** 2).sum(axis=1)))
        yield int(cluster[nearest, 0]), int(cluster[nearest, 1])


def _chains(skeleton: np.ndarray, clusters: np.ndarray) -> Iterator[Tuple[int, int, List[Cell]]]:
    """Yields each chain once: the labels of the clusters at its ends, and the cells between them.
    """
    cells = set(_cells(skeleton))
    labels = {cell: int(clusters[cell]) for cell in _cells(clusters)}
    seen = set()
    for knot, label in labels.items():
        for first in _neighbours(knot, cells):
            if first not in labels and first not in seen:
                chain = [first]
                end = _follow(chain, knot, cells, labels)
                seen.update(chain)
                yield label, labels[end], chain


def _cells(image: np.ndarray) -> List[Cell]:
    rows, columns = np.nonzero(image)
    return list(zip(map(int, rows), map(int, columns)))


def _neighbours(cell: Cell, cells: set) -> List[Cell]:
    row, column = cell
    return [(row + down, column + right) for down, right in _AROUND
            if (row + down, column + right) in cells]


def _follow(chain: List[Cell], knot: Cell, cells: set, labels: Dict[Cell, int]) -> Cell:
    """Extends a chain that begins beside `knot` up to the next knot, and returns the next knot.

    A cell that is not a knot has exactly two neighbours: the previous cell and the next one.
    """
    before = knot
    while True:
        onward, = (cell for cell in _neighbours(chain[-1], cells) if cell != before)
        if onward in labels:
            return onward
        before = chain[-1]
        chain.append(onward)
