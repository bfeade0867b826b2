"""Rare events: robots are not where their orders lead, or the journal lacks their last orders.

The fleet manager learns of these events only from reports. Therefore each event leaves other robots
enough room to stop: the fleet manager cannot prevent a person from pushing one robot into another.
"""
from __future__ import annotations

import math
from typing import Sequence, Tuple

from shapely.geometry import Point

from fleet_core.interlocking.reports import TREMBLE
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.run_number import RUN_NUMBER
from fleet_simulation.virtual_fleet import STEP
from world.chaos import YARD, Chaos, Event

_PUSH = 0.05  # m; distance by which a person pushes a robot in one step
_PUSHES = (2, 6, 20, 40)  # numbers of such steps
_SHARES = (0.0, 0.25, 0.5, 0.75)
_ASIDE = (0.03, 0.1, 0.3, 0.6)  # m
_SIDES = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))
_HOUR = 3600.0
_REACTION = 0.5  # s; time from an event until a stop reaches a robot, if no message is late
_MORE = 0.05  # m; additional free space that a person leaves


class RareChaos(Chaos):
    """The events of `Chaos`, and rare ones."""

    def happen(self, event: Event) -> None:
        """Waits for the event's moment, then lets the event happen.

        No message is lost while a robot is moved: other robots must be able to stop in time.
        """
        network = self.fleet.network
        loss, network.loss = network.loss, 0.0 if event.act in MOVING else network.loss
        super().happen(event)
        network.loss = loss

    def older_journal(self, _: str, number: int) -> None:
        """Copies the journal. Later, the supervisor starts with the copy.

        The clock of the supervisor's computer is right, or was set back. If the copy was made
        during the same run of the supervisor, only reports show that it is old. So all robots must
        report without delay.
        """
        fleet = self.fleet
        copy = fleet.disk.copy()
        if number % 2:
            fleet.restart()

        def put_back() -> None:
            is_of_this_run = copy.execute(
                'SELECT number FROM value WHERE name = ?', (RUN_NUMBER,)).fetchone() == (
                    fleet.disk.journal.number_beside(),)
            if is_of_this_run and (fleet.network.loss or not all(map(self.tells, fleet.agvs))):
                return
            fleet.disk.set_back += _HOUR * (number // 2 % 2)
            self.promises.begins_with_older_journal()
            fleet.disk.put_back(copy)
            fleet.restart()
            if fleet.supervisor.is_stopped:
                self.promises.stop()
            for name, robot in fleet.supervisor.robots.items():
                if robot.outage is Outage.OUT_OF_SERVICE:
                    self.promises.take_out(name)

        self.later(number // 4, put_back)

    def put_down(self, robot: str, number: int) -> None:
        """Lets a person take a robot out of service, and carry it near others, or onto a route."""
        robot = self._that_stands(robot)
        if not self.fleet.supervisor.robots[robot].needs_person:
            self.take_out(robot, 0)
            self.run(2.0 * STEP)
        if not self.can_be_carried(robot):
            return
        places = [(edge, share) for edge in sorted(self.fleet.graph.edges) for share in _SHARES
                  if not self.is_far(robot, edge, share) and self._has_room(
                      robot, YARD.curve(edge).point_at(share * YARD.curve(edge).length))]
        on_routes = [(edge, share) for edge, share in places if any(
            edge in map(abs, self.promises.may_drive(name)) for name in self.fleet.agvs)]
        places = on_routes or places
        if places:
            edge, share = places[number % len(places)]
            self.promises.blamed.add(robot)
            self.promises.carried.add(robot)
            self.fleet.agvs[robot].be_carried(edge, share * YARD.curve(edge).length)
            self._react()

    def push(self, robot: str, number: int) -> None:
        """Lets a person push a standing robot along the edges, until another robot is near."""
        robot = self._that_stands(robot)
        agv = self.fleet.agvs[robot]
        if not self.tells(robot):
            return
        for _ in range(_PUSHES[number // 2 % len(_PUSHES)]):
            edge, arc = self._pushed(robot, number)
            x, y = YARD.curve(edge).point_at(arc)
            if agv.is_driving or abs(edge) not in self.fleet.graph.edges or not self._has_room(
                    robot, (x + agv.aside[0], y + agv.aside[1])):
                break
            self.promises.blamed.add(robot)
            self.promises.carried.add(robot)
            agv.edge, agv.arc = edge, arc
            self.run(STEP)
            number |= 1
        self._react()

    def _pushed(self, robot: str, number: int) -> Tuple[int, float]:
        """Returns the next place of a pushed robot; it is pushed forward if `number` is odd."""
        agv = self.fleet.agvs[robot]
        length = YARD.curve(agv.edge).length
        edge, arc = (agv.edge, agv.arc) if number % 2 else (-agv.edge, length - agv.arc)
        if arc + _PUSH <= length:
            return edge, arc + _PUSH
        onward = [one for one in YARD.edges_from(YARD.end_vertex(edge).id) if one != -edge]
        return (onward[number % len(onward)], _PUSH) if onward else (edge, length)

    def stray(self, robot: str, number: int) -> None:
        """Puts a robot beside its edge, within its play or farther away, until its next route.

        The robot's reports show this place as exactly as a real robot knows it. A standing robot
        counts as pushed there.
        """
        agv, (x, y) = self.fleet.agvs[robot], _SIDES[number // 4 % 4]
        size = _ASIDE[number % 4]
        is_within = size <= agv.kind.play and agv.is_driving
        place = tuple(on_map - before + size * side for on_map, before, side in zip(
            agv.position, agv.aside, (x, y)))
        if not is_within and not (self.tells(robot) and self._has_room(robot, place)):
            return
        agv.aside = size * x, size * y
        agv.error = (TREMBLE - 0.01) * x, (TREMBLE - 0.01) * y
        self.promises.carried.add(robot)
        if not is_within:
            self.promises.blamed.add(robot)
            self._react()

    def bring_in(self, robot: str, number: int) -> None:
        """Brings a robot into service. If the robot is beside its edge or too near to another
        robot, a person moves it instead.
        """
        agv, supervisor = self.fleet.agvs[robot], self.fleet.supervisor
        if math.hypot(*agv.aside) > agv.kind.play:
            self._carry_away(robot, number)
            return
        super().bring_in(robot, number)
        if supervisor.robots[robot].outage is Outage.TOO_NEAR and (
                supervisor.interlocking.excluding(robot)):
            self._carry_away(robot, number)

    def _carry_away(self, robot: str, number: int) -> None:
        for k in range(2 * len(self.fleet.graph.edges)):
            if robot not in self.promises.carried:
                self.carry(robot, number + k)

    def _that_stands(self, robot: str) -> str:
        """Returns this robot if it stands; if not, another standing robot, if there is one."""
        return min((robot, *self.fleet.agvs), key=lambda name: self.fleet.agvs[name].is_driving)

    def _react(self) -> None:
        """Waits, for at most 6 s, until all robots that exclude other robots stand, or cannot be
        stopped.
        """
        fleet = self.fleet
        self.run(2.0 * STEP)
        self.run_until(lambda: not any(
            fleet.agvs[name].is_driving and fleet.supervisor.interlocking.excluding(name)
            and self._can_be_stopped(name) for name in fleet.agvs), 6.0)

    def _has_room(self, robot: str, place: Sequence[float]) -> bool:
        """Returns whether all other robots have enough room to stop before a robot at this place.
        """
        fleet, agvs = self.fleet, self.fleet.agvs
        own = self._way_to_stop(robot)
        for name in agvs.keys() - {robot}:
            least = agvs[robot].kind.radius + agvs[name].kind.radius + fleet.clearance + _MORE + own
            way = self._way_to_stop(name)
            left = (math.dist(place, agvs[name].position) - way if way < math.inf else
                    Point(place).distance(self.promises.possible(
                        name, self.promises.may_drive(name))))
            if left < least:
                return False
        return True

    def _way_to_stop(self, name: str) -> float:
        """Returns how far (m) a robot may still drive until it has obeyed a stop; inf: no stop
        reaches it.
        """
        fleet, agv = self.fleet, self.fleet.agvs[name]
        if not self.promises.may_drive(name) and (
                fleet.supervisor.is_stopped or fleet.supervisor.robots[name].needs_person):
            return 0.0
        if not self._can_be_stopped(name):
            return math.inf
        late = fleet.network.orders_late.get(name, 0.0)
        return (_REACTION + late) * agv.kind.speed + agv.braking

    def _can_be_stopped(self, name: str) -> bool:
        """Returns whether a stop reaches a robot. A robot left to a person gets only one stop."""
        fleet = self.fleet
        is_by_hand = fleet.supervisor.robots[name].needs_person and fleet.agvs[name].is_driving
        return not is_by_hand and name not in fleet.lost and fleet.network.hears(name, fleet.now)


MOVING = tuple(act.__name__ for act in (RareChaos.put_down, RareChaos.push, RareChaos.stray))
"""The names of the events after which a robot is not at the place to which its orders lead."""
RARE = (RareChaos.older_journal.__name__, *MOVING)
"""The names of the rare events."""
