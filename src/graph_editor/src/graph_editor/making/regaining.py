"""Places that went with the lanes to them, once other lanes lead near."""
from __future__ import annotations

from typing import Dict, Iterable, Sequence, Tuple

from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.places import attach_places
from graph_editor.making.widening import Gap, widen
from graph_editor.site import Place


def regain(net: LaneNet, gaps: Iterable[Gap], places: Dict[int, Place], options: MakingOptions,
           homes: Sequence[Tuple[float, float]]) -> LaneNet:
    """The net with each place behind a gap to which lanes with room for robots can lead after all.

    Adds their nodes to `places`. Each is tried on a copy: to a place that costs the net anything
    else, no lane is drawn.
    """
    for place in (place for gap in gaps for place in gap.places):
        tried = net.copy()
        nodes = attach_places(tried, [place], options, places).nodes
        if len(nodes) > len(places) and not widen(tried, options, nodes, homes):
            net = tried
            places.update(nodes)
    return net
