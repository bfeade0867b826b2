"""A way out of any tangle: search over the places of all robots at once.

Where robots planned one after the other get stuck, this search moves all of them step by step, as
LaCAM does (Okumura, LaCAM: Search-based algorithm for quick multi-agent pathfinding, AAAI 2023):
depth first over configurations, each next one made by letting robots choose in the order of their
priorities, and if a configuration comes up again, by forcing single robots to other moves. In a
step robots stay or drive one edge, and no robot enters what another leaves: steps made otherwise
would make orders in which robots wait for each other in a ring. So no two moves of a step exclude
each other, and their order from step to step is all that a plan needs.
"""
from __future__ import annotations

import time
from collections import deque
from random import Random
from typing import Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple

from graph_fleet_manager.planning.configuration_step import Mover, StepMaker, choose_rests
from graph_fleet_manager.planning.timetable import Timetable
from graph_fleet_manager.planning.travellers import Traveller

Configuration = Tuple[int, ...]
"""For each robot its vertex and its leg, in one number: leg * vertices + vertex."""

_Forced = Tuple[Tuple[int, int], ...]
"""(robot, drive or STAY) that a step must contain."""


class _Node(NamedTuple):
    configuration: Configuration
    parent: Optional[_Node]
    moves: Dict[int, int]  # robot: drive that led here from the parent
    waiting: List[float]   # priority of each robot
    order: List[int]
    tree: Deque[_Forced]


def search_configurations(timetable: Timetable, travellers: Sequence[Traveller], deadline: float,
                          random: Random) -> Optional[List[Tuple[str, int]]]:
    """The drives of all robots (robot, drive) in an order that leads everybody to its end.

    It begins where everybody's fixed drives end. Robots that may rest in several places rest in the
    one that each has been given by the order of the travellers: the nearest that is still free.
    None where there is no way, or the deadline (monotonic s) came first.
    """
    rests = choose_rests(timetable, travellers)
    if rests is None:
        return None
    maker = StepMaker(timetable, travellers, rests, random)
    if (any(any(slots.bookings) for slots in timetable.slots.values())
            and not all(mover.has_way() for mover in maker.movers)):
        return None  # somebody stands in the way for ever
    movers = maker.movers
    first = tuple(mover.begin for mover in movers)
    root = _Node(first, None, {}, _first_waiting(movers, first), [], deque([()]))
    root.order.extend(_order(root.waiting))
    known: Dict[Configuration, _Node] = {first: root}
    stack = [root]
    while stack and time.monotonic() < deadline:
        node = stack[-1]
        if maker.is_end(node.configuration):
            return _drives(node, movers)
        if not node.tree:
            stack.pop()
            continue
        forced = node.tree.popleft()
        if len(forced) < len(movers):
            robot = node.order[len(forced)]
            for move in maker.choices(robot, node.configuration[robot]):
                node.tree.append((*forced, (robot, move)))
        step = maker.step(node.configuration, node.order, dict(forced))
        if step is None:
            continue
        configuration, moves, promoted = step
        if configuration in known:
            again = known[configuration]
            if again is not node:
                stack.append(again if again.tree else node)
            continue
        waiting = _next_waiting(node.waiting, configuration, movers, promoted)
        child = _Node(configuration, node, moves, waiting, _order(waiting), deque([()]))
        known[configuration] = child
        stack.append(child)
    return None


def _first_waiting(movers: Sequence[Mover], configuration: Configuration) -> List[float]:
    longest = max((mover.to_go(place) for mover, place in zip(movers, configuration)), default=1.0)
    return [mover.to_go(place) / (longest + 1.0)
            for mover, place in zip(movers, configuration)]


def _next_waiting(waiting: Sequence[float], configuration: Configuration, movers: Sequence[Mover],
                  promoted: Sequence[Tuple[int, int]]) -> List[float]:
    """Who has not arrived gets more urgent; who let somebody out lets him go first from now on."""
    following = [value - int(value) if mover.is_end(place) else value + 1.0
                 for value, mover, place in zip(waiting, movers, configuration)]
    for before, behind in promoted:
        if following[before] <= following[behind]:
            following[before] = following[behind] + 1e-3
    return following


def _order(waiting: Sequence[float]) -> List[int]:
    return sorted(range(len(waiting)), key=lambda robot: -waiting[robot])


def _drives(node: _Node, movers: Sequence[Mover]) -> List[Tuple[str, int]]:
    steps = []
    while node.parent is not None:
        steps.append([(movers[robot].name, drive) for robot, drive in node.moves.items()])
        node = node.parent
    return [move for step in reversed(steps) for move in step]
