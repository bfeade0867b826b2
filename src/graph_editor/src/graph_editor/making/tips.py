"""Moves the tips of dead ends to places where robots can turn, so that robots can drive back."""
from __future__ import annotations

from typing import Collection, Optional, Sequence, Tuple

import numpy as np

from graph_editor.making.coverage import Coverage
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import MakingOptions
from graph_editor.making.sight import straight
from graph_editor.making.straights import Margin, margins_of, places_to_turn, room_between
from graph_editor.making.tidying import CLOSE, LEAST_FLOOR
from graph_editor.making.widening import ASIDE


def give_tips_room(net: LaneNet, coverage: Coverage, options: MakingOptions,
                   keep: Collection[int], homes: Sequence[Tuple[float, float]]) -> None:
    """Moves the tips of dead ends, except the nodes to `keep`, to places at which robots can turn.

    - A tip moves back along its lane.
    - If this would leave much floor unserved, the tip moves to a place beside the lane that can be
      reached on a straight lane.
    - A dead end that becomes too short is removed.
    - If the only remaining lane has no place to turn, a single node replaces it: a place to turn
      near a start of robots (`homes`, m) or near the lane. If there is no such place, the lane
      stays.
    """
    for tip in net.nodes:
        if tip in keep or tip not in net.positions or net.degree(tip) != 1:
            continue
        base, = net.neighbours(tip)
        last = len(net.lanes) == 1
        place = _place_for(net, coverage, tip, base, options)
        if place is not None and np.hypot(*(place - net.positions[base])) >= (
                net.floor.resolution if last else CLOSE):
            net.positions[tip] = place
        elif not last or place is not None:
            net.remove_node(tip)
        elif base not in keep:
            _leave(net, (tip, base), options, homes)


def _place_for(net: LaneNet, coverage: Coverage, tip: int, base: int,
               options: MakingOptions) -> Optional[np.ndarray]:
    """Returns the place to turn for the end of a lane.

    This place is on the lane, or beside its tip if a place on the lane would leave much floor
    unserved.
    """
    here = net.positions[tip]
    points = straight(net.floor, here, net.positions[base])
    roomy = np.flatnonzero(net.floor.clearance_at(points) >= options.turning)
    back = points[roomy[0]] if len(roomy) else None
    if back is not None and np.array_equal(back, here) or len(net.lanes) > 1 and (
            _left_unserved(net, coverage, tip, base, back) < LEAST_FLOOR):
        return back
    room_to_bend = net.floor.clearance_of(net.positions[base])
    for margin in margins_of(options):
        if net.degree(base) == 1 or room_to_bend >= margin.turning:
            places = _nearest_to_turn(net, here, margin)
            free = room_between(net.floor, net.positions[base], places) >= margin.straight
            if free.any():
                return places[int(np.argmax(free))]
    return back


def _left_unserved(net: LaneNet, coverage: Coverage, tip: int, base: int,
                   back: Optional[np.ndarray]) -> float:
    """Returns the area (m2) that no lane would serve if this lane ended at `back`.

    back -- the new end of the lane; None: the lane is removed
    """
    lane = net.lane(tip, base)
    kept = [np.array(net.ends(other)) for other in net.lanes if other.nodes != lane.nodes]
    if back is not None:
        kept.append(np.array((net.positions[base], back)))
    served = coverage.covered_by(np.array(net.ends(lane)))
    servants = np.zeros(coverage.mask.size, np.int32)
    servants[served] = 1
    for path in kept:
        servants[coverage.covered_by(path)] += 1
    return coverage.left_without(servants, served)


def _nearest_to_turn(net: LaneNet, start: np.ndarray, margin: Margin) -> np.ndarray:
    """Returns places to turn (N,2) near `start`, the nearest first."""
    places = places_to_turn(net.floor, start - ASIDE, start + ASIDE, margin)
    return places[np.argsort(np.linalg.norm(places - start, axis=1), kind='stable')]


def _leave(net: LaneNet, lane: Tuple[int, int], options: MakingOptions,
           homes: Sequence[Tuple[float, float]]) -> None:
    """Replaces a lane without a place to turn by one place to turn."""
    for start in (*map(np.array, homes), *(net.positions[node] for node in lane)):
        places = _nearest_to_turn(net, start, margins_of(options)[-1])
        if len(places):
            for node in lane:
                net.remove_node(node)
            net.add_node(places[0])
            return
