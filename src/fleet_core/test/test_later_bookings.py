"""Bookings that are made only when they are read equal bookings that are made immediately."""
from __future__ import annotations

from random import Random
from typing import Dict, List, Optional, Tuple

import pytest
from fleet_builders import random_graph
from fleet_cases import MidEdgeCase
from proofs import is_whole

from fleet_core.fleet import RobotType
from fleet_core.planning.later_bookings import Booked
from fleet_core.planning.mid_edge import MidEdgePosition
from fleet_core.planning.planner import FleetPlanner
from fleet_core.planning.plans import Drive
from fleet_core.planning.reservation_table import ReservationTable
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import Task

WHOLE = is_whole(__file__)
KINDS = (RobotType('small', 0.2, 1.3), RobotType('large', 0.5, 1.0))


class Pair:
    """Two tables with the same bookings: one makes them immediately, the other one later."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.network = RoadNetwork(random_graph(self.random, 12, 8, 1.5))
        self.tables = [ReservationTable(self.network, 0.1, KINDS) for _ in range(2)]
        for table in self.tables:
            table.book_places('obstacle', KINDS[0], [self.random.randrange(1)])
        robots = {f'r{k}': self._robot() for k in range(6)}
        for name, robot in robots.items():
            self._book(self.tables[0], name, robot)
        self.tables[1].book_later(robots)
        self.names = list(robots)

    def _robot(self) -> Booked:
        kind = self.random.choice(KINDS)
        vertex, now = self.random.randrange(self.network.vertices), 0.0
        mid_edge: Optional[MidEdgePosition] = None
        plan: List[Drive] = []
        for number in range(self.random.randrange(6)):
            drive = self.random.choice([d for d, origin in enumerate(self.network.origin)
                                        if origin == vertex])
            begun = self.random.choice((0.0, 0.0, 0.4)) if number == 0 else 0.0
            if begun and self.random.random() < 0.5:
                mid_edge = MidEdgePosition(drive, begun, 1.0, 1.0)
            start = now + self.random.choice((0.0, 0.0, 2.5))
            now = start + self.random.uniform(0.5, 3.0)
            plan.append(Drive(drive, start, now, begun))
            vertex = self.network.destination(drive)
        first = self.network.origin[plan[0].drive] if plan else vertex
        until = self.random.choice((float('inf'), float('inf'), now + 4.0))
        held = 0 if mid_edge else self.random.randint(0, len(plan))
        return self.tables[0].state(kind, first, plan, mid_edge, until, held)

    @staticmethod
    def _book(table: ReservationTable, name: str, robot: Booked) -> None:
        table.book(name, robot.kind, robot.vertex, robot.plan, robot.mid_edge, robot.until,
                   robot.held)

    def change(self) -> None:
        """Makes the same random change in both tables."""
        name, robot = self.random.choice(self.names), self._robot()
        act = self.random.choice(('cancel', 'book', 'take out', 'take out', 'look'))
        slot, group = self.random.randrange(self.network.drives), self.random.sample(self.names, 2)
        for table in self.tables:
            if act == 'look':
                table.slots[KINDS[0]].busy(slot)
            elif act == 'take out' and all(one in table.booked for one in group):
                taken = table.take_out(group)
                self._book(table, group[0], robot)
                table.put_back(taken)
            elif act in ('cancel', 'book'):
                table.cancel(name)
                if act == 'book':
                    self._book(table, name, robot)

    def seen(self, table: ReservationTable) -> Dict[str, Tuple]:
        """All data of a table that searches can read."""
        return {kind.name: (
            [slots.row(slot) for slot in range(len(slots.merged))],
            [tuple(map(tuple, slots.busy(slot))) for slot in range(len(slots.merged))],
            slots.horizon,
            {name: {slot: row for slot, row in table.bookings_of(name, kind).items() if row}
             for name in table.booked})
            for kind, slots in table.slots.items()}


@pytest.mark.parametrize('seed', range(60 if WHOLE else 20))
def test_bookings_made_later_are_those_made_at_once_whatever_is_changed_and_looked_at(seed):
    pair = Pair(seed)
    for _ in range(pair.random.randrange(5)):
        pair.change()
    at_once, later = map(pair.seen, pair.tables)
    assert later == at_once


def at_once(table: ReservationTable, robots: Dict[str, Booked]) -> None:
    """Books all robots at once."""
    for name, robot in robots.items():
        table.book(name, robot.kind, robot.vertex, robot.plan, robot.mid_edge, robot.until,
                   robot.held)


@pytest.mark.parametrize('seed', range(40 if WHOLE else 10))
def test_plans_are_the_same_as_with_a_table_whose_bookings_are_made_at_once(seed, monkeypatch):
    random = Random(seed)
    case = MidEdgeCase(random)
    network = case.network.with_closed(case.closed)
    parking = tuple(case.graph.vertices)
    tasks = [Task(name, task.type, task.vertex, mid_edge=task.mid_edge,
                  destinations=case.missions.get(name, ()))
             for name, task in case.robots.items()]

    def plan(given: List[Task], rounds: int):
        planner = FleetPlanner(network, case.clearance, case.types, parking)
        return planner.plan(given, rounds=rounds)

    first = plan(tasks, 0)
    vertices = sorted(case.graph.vertices)
    changed = random.choice(tasks).name if tasks else ''
    again = [Task(task.name, task.type, task.vertex, mid_edge=task.mid_edge,
                  destinations=((random.choice(vertices),) if task.name == changed
                                else task.destinations),
                  kept=None if task.name == changed else first.drives[task.name])
             for task in tasks]
    rounds = random.choice((0, 5))
    later = plan(again, rounds)
    monkeypatch.setattr(ReservationTable, 'book_later', at_once)
    assert plan(again, rounds) == later
