"""Restores places that were removed together with their lanes, if other lanes lead near them."""
from __future__ import annotations

from typing import Dict, Iterable, Sequence, Tuple

from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.places import attach_places
from graph_editor.making.widening import Gap, widen
from graph_editor.site import NamedPlace


def regain(net: LaneNet, gaps: Iterable[Gap], places: Dict[int, NamedPlace], options: MakingOptions,
           homes: Sequence[Tuple[float, float]]) -> LaneNet:
    """Adds places that lanes can reach after all, although gaps lie before them.

    Returns the new net.

    The nodes of these places are added to `places`. Each place is tried on a copy of the net. A
    place is not added if that would cause another gap.
    """
    for place in (place for gap in gaps for place in gap.places):
        tried = net.copy()
        nodes = attach_places(tried, [place], options, places).nodes
        if len(nodes) > len(places) and not widen(tried, options, nodes, homes):
            net = tried
            places.update(nodes)
    return net
