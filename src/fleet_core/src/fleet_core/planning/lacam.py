"""LaCAM: a search over the places of all robots at once, for robots that block each other.

If planning one robot after the other fails, this search moves all robots step by step (Okumura,
LaCAM: Search-based algorithm for quick multi-agent pathfinding, AAAI 2023). It searches
configurations depth first. For the next configuration, robots choose their moves in the order of
their priorities. If a configuration is reached again, single robots are forced to move otherwise.

In a step each robot stays or drives one edge. No robot enters a place that another robot leaves in
the same step: otherwise robots could wait for each other in a ring. So no two moves of a step
exclude each other, and a plan needs only the order of the steps.
"""
from __future__ import annotations

import time
from collections import deque
from math import inf
from random import Random
from typing import Deque, Dict, List, NamedTuple, Optional, Sequence, Tuple

from fleet_core.planning.agents import Agent
from fleet_core.planning.pibt import Pibt, PibtAgent, choose_rests
from fleet_core.planning.reservation_table import ReservationTable

Configuration = Tuple[int, ...]
"""The state of each robot: leg * vertices + vertex."""

_Forced = Tuple[Tuple[int, int], ...]
"""The moves (robot, drive or STAY) that a step must contain."""


class _Node(NamedTuple):
    configuration: Configuration
    parent: Optional[_Node]
    moves: Dict[int, int]  # by robot: the drive from the parent to here
    waiting: List[float]   # priority of each robot
    order: List[int]
    tree: Deque[_Forced]


def search_lacam(reservations: ReservationTable, given: Sequence[Agent], deadline: float,
                 random: Random, most_steps: float = inf) -> Optional[List[Tuple[str, int]]]:
    """Returns the drives (robot, drive) that lead all robots to their ends, in a safe order.

    given -- robots that are not booked, by descending urgency

    The search begins where the fixed drives end. A robot that may rest in several places rests in
    the nearest one that is still free when its turn comes. Returns None if there is no path, or if
    the deadline (monotonic s) or `most_steps` is reached first.
    """
    rests = choose_rests(reservations, given)
    if rests is None:
        return None
    pibt = Pibt(reservations, given, rests, random)
    if not (reservations.is_empty or all(agent.has_path(deadline) for agent in pibt.agents)):
        return None  # a robot blocks the only path for ever
    agents = pibt.agents
    first = tuple(agent.begin for agent in agents)
    root = _Node(first, None, {}, _first_waiting(agents, first), [], deque([()]))
    root.order.extend(_order(root.waiting))
    known: Dict[Configuration, _Node] = {first: root}
    stack = [root]
    steps = 0
    while stack and time.monotonic() < deadline and steps < most_steps:
        steps += 1
        node = stack[-1]
        if pibt.is_end(node.configuration):
            return _drives(node, agents)
        if not node.tree:
            stack.pop()
            continue
        step = pibt.step(node.configuration, node.order, dict(_next_forced(node, pibt)))
        if step is None:
            continue
        configuration, moves, promoted = step
        if configuration in known:
            again = known[configuration]
            if again is not node:
                stack.append(again if again.tree else node)
            continue
        waiting = _next_waiting(node.waiting, configuration, agents, promoted)
        child = _Node(configuration, node, moves, waiting, _order(waiting), deque([()]))
        known[configuration] = child
        stack.append(child)
    return None


def _next_forced(node: _Node, pibt: Pibt) -> _Forced:
    """Returns the moves that the next step must contain.

    Adds requirements for later steps: these moves, and one possible move of one more robot.
    """
    forced = node.tree.popleft()
    if len(forced) < len(node.order):
        robot = node.order[len(forced)]
        node.tree.extend((*forced, (robot, move))
                         for move in pibt.choices(robot, node.configuration[robot]))
    return forced


def _first_waiting(agents: Sequence[PibtAgent], configuration: Configuration) -> List[float]:
    longest = max((agent.to_go(state) for agent, state in zip(agents, configuration)), default=1.0)
    return [agent.to_go(state) / (longest + 1.0)
            for agent, state in zip(agents, configuration)]


def _next_waiting(waiting: Sequence[float], configuration: Configuration,
                  agents: Sequence[PibtAgent], promoted: Sequence[Tuple[int, int]]) -> List[float]:
    """Returns the next priorities. The priority of a robot that has not arrived rises.

    A robot that let another robot go first gets a lower priority than that robot.
    """
    following = [value - int(value) if agent.is_end(state) else value + 1.0
                 for value, agent, state in zip(waiting, agents, configuration)]
    for before, behind in promoted:
        if following[before] <= following[behind]:
            following[before] = following[behind] + 1e-3
    return following


def _order(waiting: Sequence[float]) -> List[int]:
    return sorted(range(len(waiting)), key=lambda robot: -waiting[robot])


def _drives(node: _Node, agents: Sequence[PibtAgent]) -> List[Tuple[str, int]]:
    steps = []
    while node.parent is not None:
        steps.append([(agents[robot].name, drive) for robot, drive in node.moves.items()])
        node = node.parent
    return [move for step in reversed(steps) for move in step]
