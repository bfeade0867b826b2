"""Each change of a robot's state causes a notification, so that no derived value is out of date.

A report without news costs little, because the supervisor examines a robot again only after a
notification. There are three kinds of derived values, and none of them may be older than the
robot's state:

- `RouteMaster` notifies when its state changes. The allocation and the tables of the interlocking
  are derived from this state.
- The journal stores a robot again when its `progress` changes, or after a notification.
- The check of a plan against the world examines a robot again when the robot's version number
  grows.

The names of the fields are read from the objects and types themselves, so a new field is also
compared. Two tables name the fields that may change without a notification, and the reasons.
"""
from __future__ import annotations

import copy
import random
from collections import deque
from dataclasses import fields, replace
from typing import Any, Callable, Dict, Optional, Sequence, Tuple

import pytest
from fleet_builders import corridor
from proofs import LONG, is_whole

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.interlocking.reports import GraphPosition, Report
from fleet_core.interlocking.route_master import Heard, Memory, RouteMaster
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.actions import Action
from fleet_core.supervision.journal import RobotMemory
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.settings import RobotSettings
from route_protocol.messages import WrongReport
from route_protocol.values import (
    EdgeState,
    EpochCause,
    Motion,
    RouteReport,
    SymbolicPose,
    VehicleLocation,
)
from world.chaos import DOCKS, PARKING, PEOPLE, ROBOTS, SAME, TROUBLE, YARD, Event
from world.rare_events import MOVING, RARE, RareChaos
from world.supervised_fleet import SupervisedFleet

WHOLE = is_whole(__file__)
LIVES = 60 if LONG else 12 if WHOLE else 1
DRIVES = 20000 if LONG else 3000 if WHOLE else 200  # random drives of one robot
AGV = RobotType('agv', 0.4, 1.0, docks=frozenset(DOCKS), play=0.1)
GRAPH = corridor(4)
ME = 'path_supervisor'

Fields = Dict[str, object]

UNTOLD = {
    # fields that never change
    'graph', '_slack', '_clock', '_tell', 'record',
    # values derived from the other fields; `check_kept` compares them
    '_allocation', '_elsewhere', '_progress',
    # values that are read anew at each use: the time and label of an order, the newest location
    '_sent', 'last_sent', 'is_new_motion', '_label', '_told',
    # values that contain the number of the last report; they are compared without this number
    'protocol', 'memory'}
"""Fields and answers of a route master and its record that may change without a notification."""
ANSWERS = [name for name, one in vars(RouteMaster).items()
           if isinstance(one, property) and not name.startswith('_') and name not in UNTOLD]
MAY_BE_OLDER: Dict[str, Callable[[Any, Any], bool]] = {
    # with an older value of these two fields, the robot only holds more edges
    'cleared': lambda stored, now: stored <= now,
    'behind': lambda stored, now: set(stored) >= set(now),
    # a report that is received twice changes nothing
    'report': lambda stored, now: stored <= now,
    # drawn anew at each start
    'gap': lambda stored, now: True,
    # judged anew at each start
    'commands': lambda stored, now: True,
    'charge': lambda stored, now: True,
    # after each start, a robot is UNSEEN
    'outage': lambda stored, now: stored is None and now is Outage.UNSEEN}
"""Fields of the stored state that may differ from the present state, and the permitted difference.
"""


def state_of(master: RouteMaster) -> Fields:
    """Returns the fields of a route master and its record, and its answers, except `UNTOLD`."""
    found: Fields = {name: getattr(master, name) for name in ANSWERS}
    for owner in (master, master.record):
        for name, value in vars(owner).items():
            if name not in UNTOLD:
                found[name] = tuple(value) if isinstance(value, deque) else value
    return {**found, 'protocol': replace(master.protocol, report=0)}


def different(before: Fields, now: Fields) -> Dict[str, Tuple[object, object]]:
    """Returns the fields that differ, with both values."""
    return {name: (before.get(name), now.get(name)) for name in {**before, **now}
            if before.get(name) != now.get(name)}


def fields_of(memory: Memory) -> Fields:
    """Returns all fields of the stored state of a route master by name."""
    found = {**memory._asdict(),
             **{one.name: getattr(memory.protocol, one.name) for one in fields(memory.protocol)}}
    del found['protocol']
    return found


def stored_fields(memory: RobotMemory) -> Fields:
    """Returns all fields of the stored state of a robot by name."""
    kind = memory.kind
    found = {**memory._asdict(), **fields_of(memory.master),
             'kind': kind and (kind.name, kind.radius, kind.fastest, kind.play)}
    del found['master']
    return found


def wrong_in(stored: Fields, now: Fields) -> Dict[str, Tuple[object, object]]:
    """Returns the stored fields that are out of date, except those that may be."""
    return {name: pair for name, pair in different(stored, now).items()
            if not MAY_BE_OLDER.get(name, lambda *_: False)(*pair)}


def check_kept(master: RouteMaster) -> None:
    """Checks that the derived values of a route master agree with its present state."""
    fresh = copy.copy(master)
    fresh._allocation = fresh._elsewhere = fresh._progress = None
    assert master.allocation == fresh.allocation
    assert master.progress == fresh.progress


# -- one robot -------------------------------------------------------------------------------------


class Drive:
    """A robot and its route master. Each report differs a little from the previous report."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(f'drive {seed}')
        self.told = 0
        self.now = 1000
        self._start(Memory())
        self.said = RouteReport(0, 0, (), (), SymbolicPose(1, 0.0), epoch=1, master=ME,
                                motion=Motion.STANDING)

    def _start(self, memory: Memory) -> None:
        self.told += 1
        self.master = RouteMaster(RouteRecord(GRAPH, AGV, 0.1), self._clock, self._tell)
        self.master.restore(memory)

    def _clock(self) -> int:
        return self.now

    def _tell(self) -> None:
        self.told += 1

    def happen(self) -> None:
        """Lets one event happen, and checks that each change caused a notification."""
        master, told = self.master, self.told
        before, stored, progress = state_of(master), master.memory, master.progress
        check_kept(master)
        self.now += 100
        is_report = self.draw.random() < 0.7
        if is_report:
            self._report()
        else:
            self.draw.choice((self._extend, self._command))()
        if self.told == told:
            assert not different(before, state_of(master)), 'a change was not told'
        check_kept(self.master)
        if is_report and master.progress == progress:
            older = wrong_in(fields_of(stored), fields_of(master.memory))
            assert not older, 'a change of the stored state would not be stored'

    def _report(self) -> None:
        draw, said = self.draw, self.said
        for _ in range(draw.choice((0, 0, 1, 1, 2))):
            said = replace(said, **draw.choice((
                self._place, self._place, self._location, self._order, self._motion, self._epoch,
                self._refusal, self._route, self._nowhere))(said))
        report = Report(replace(said, number=self.now), draw.choice((0.0, 0.0, 0.0, 2.0, -1.0)))
        try:
            self.master.hear(report)
        except WrongReport:
            return
        self.said = said

    def _place(self, _: RouteReport) -> Dict[str, Any]:
        edge = self.draw.choice((0, 1, 2, 3, -1, -2, -3))
        share = self.draw.choice((0.0, 20.0, 50.0, 90.0, 100.0)) if edge else 0.0
        return {'pose': SymbolicPose(edge, share), 'location': None, 'stamp': self.now * 10 ** 6}

    def _nowhere(self, _: RouteReport) -> Dict[str, Any]:
        return {'pose': SymbolicPose(0, 0.0), 'location': None, 'stamp': 0}

    def _location(self, said: RouteReport) -> Dict[str, Any]:
        aside = self.draw.choice((0.0, 0.02, 0.4, 3.0))
        along = self.draw.uniform(0.0, 6.0)
        return {'location': self.draw.choice((None, VehicleLocation(along, aside, 0.0))),
                'stamp': self.draw.choice((0, said.stamp, self.now * 10 ** 6))}

    def _order(self, said: RouteReport) -> Dict[str, Any]:
        """Lets the robot take an order."""
        if not self.master.protocol.open:
            return {}
        order = self.draw.choice(self.master.protocol.open)
        return {'order': order.number, 'first': order.first, 'edges': order.edges,
                'states': (EdgeState.PROCESSING,) * len(order.edges),
                'motion': Motion.ON_ROUTE if order.edges else Motion.STANDING}

    def _route(self, said: RouteReport) -> Dict[str, Any]:
        """Lets the robot complete edges of its route, or lets the route fail."""
        count = self.draw.randint(0, len(said.edges))
        state = self.draw.choice((EdgeState.PROCESSING, EdgeState.PROCESSING, EdgeState.FAILED))
        return {'states': ((EdgeState.COMPLETE,) * count + (state,) * len(said.edges)
                           )[:len(said.edges)]}

    def _motion(self, _: RouteReport) -> Dict[str, Any]:
        return {'motion': self.draw.choice(tuple(Motion))}

    def _epoch(self, said: RouteReport) -> Dict[str, Any]:
        return {'epoch': said.epoch + 1, 'order': 0, 'refused': 0, 'first': 0, 'edges': (),
                'states': (), 'cause': self.draw.choice(tuple(EpochCause)),
                'master': self.draw.choice((ME, ME, '', 'another'))}

    def _refusal(self, _: RouteReport) -> Dict[str, Any]:
        return {'refused': self.master.protocol.number}

    def _extend(self) -> None:
        master = self.master
        begin = master.record.last_vertex
        if begin is not None and master.is_ready:
            master.extend((self.draw.choice(GRAPH.edges_from(begin)),))
            master.due(self.now / 1000.0)

    def _command(self) -> None:
        draw, master = self.draw, self.master
        place: Optional[GraphPosition] = draw.choice(
            (GraphPosition(vertex=2), GraphPosition(edge=2, fraction=0.5)))
        draw.choice((
            master.halt, master.shorten, lambda: master.end_after(draw.randrange(2)),
            lambda: master.due(self.now / 1000.0), self._grow, self._grow,
            lambda: master.begin_at(place), lambda: master.become(draw.choice((AGV, BROAD))),
            master.doubt, lambda: master.settle(place), lambda: master.declare_absent(0.0),
            lambda: master.is_back(Report(replace(self.said, stamp=1)), self.now / 1000.0),
            *(lambda: master.lose((Area(((1.0, 0.0), (2.0, 0.0))),)),) * 3, master.not_stored,
            master.drop_stops, *(lambda: self._start(master.memory),) * 2))()

    def _grow(self) -> None:
        self.master.grow(self.draw.uniform(0.0, 9.0))


BROAD = replace(AGV, radius=0.6)


def live_alone(seed: int) -> None:
    """Simulates one robot; raises AssertionError at the first change without a notification."""
    drive = Drive(seed)
    for _ in range(30):
        drive.happen()


def test_a_route_master_tells_each_change_that_a_report_or_command_makes() -> None:
    for seed in range(DRIVES):
        live_alone(seed)


def forgets(number: int) -> property:
    """Returns the property `_known` without field `number`, as if the code lacked this field."""
    whole = RouteMaster.__dict__['_known'].fget
    return property(lambda master: (*whole(master)[:number], *whole(master)[number + 1:]))


FOUND_BY = {0: 2, 1: 31, 2: 24, 3: 0, 4: 1246, 5: 25946, 6: 33, 7: 20, 8: 5, 9: 0, 10: 11}
"""For each number of a field in `_known`: the seed of a drive in which at one moment only this
field changes.
"""


@pytest.mark.parametrize('number', FOUND_BY)
def test_a_forgotten_field_is_found(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(RouteMaster, '_known', forgets(number))
    with pytest.raises(AssertionError, match='was not told'):
        live_alone(FOUND_BY[number])


def test_a_new_field_is_covered_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    hear = RouteMaster.hear

    def hear_more(master: RouteMaster, report: Report) -> Heard:
        vars(master)['new'] = report.age
        return hear(master, report)

    monkeypatch.setattr(RouteMaster, 'hear', hear_more)
    with pytest.raises(AssertionError, match='was not told'):
        live_alone(0)


# -- a fleet ---------------------------------------------------------------------------------------


class ObservedFleet(SupervisedFleet):
    """A fleet that checks at each event that all changes caused notifications."""

    _number = -1  # number of commits at the last reading of the journal

    def _begin(self) -> None:
        self._before: Dict[str, Tuple[int, Fields]] = {}
        super()._begin()

    def do(self, actions: Sequence[Action]) -> None:
        """Checks the event from which these actions follow, and performs them."""
        self._check_masters()
        self._check_journal()
        self._check_plan()
        super().do(actions)

    def _check_masters(self) -> None:
        supervisor = self.supervisor
        supervisor.interlocking._refresh()
        for name, robot in supervisor.robots.items():
            told, now = supervisor._view._changes.of(name), state_of(robot.master)
            number, before = self._before.get(name, (-1, {}))
            if told == number:
                assert not different(before, now), f'{name} did not tell a change'
            self._before[name] = told, now
            check_kept(robot.master)
            assert supervisor.interlocking._known[name] == robot.master.allocation

    def _check_journal(self) -> None:
        if self._number != self.disk.commits:
            self._number, self._stored = self.disk.commits, self.disk.journal.robots()
        outbox = self.supervisor._out
        for name in self._stored.keys() - outbox._stale:
            memory = outbox._memory(name)
            assert memory is not None
            older = wrong_in(stored_fields(self._stored[name]), stored_fields(memory))
            if self.supervisor._run.is_wrong:  # in this case a restart makes all places doubtful
                older.pop('unknown', None)
            assert not older, f'the journal has an older state of {name}'

    def _check_plan(self) -> None:
        plan, world = self.supervisor.plan_executor.plan, self.supervisor._world()
        if plan is not None:
            assert plan.assumptions.misfits(world) == {
                name for name in world.robots if not plan.assumptions.holds(name, world)}


def live(seed: int) -> None:
    """Simulates all kinds of events; raises AssertionError at a change without a notification."""
    draw = random.Random(f'told {seed}')
    fleet = ObservedFleet(
        YARD, {name: (AGV, 21 + k) for k, name in enumerate(ROBOTS)}, seed=seed,
        loss=draw.choice((0.0, 0.05)), planning=draw.choice((0.05, 0.3)), parking=PARKING,
        check_every=10 ** 9, settings=RobotSettings(release_ahead=draw.choice((0.0, 3.0, 8.0))))
    chaos = RareChaos(fleet)
    fleet.watcher = None  # other tests check the promises
    acts = ('request',) * 12 + (*PEOPLE, *TROUBLE, *RARE * 2, *MOVING * 3)
    for _ in range(40):
        chaos.happen(Event(draw.choice(acts), draw.choice(('now', 'now', 'order', 'plan')),
                           draw.choice((SAME, 0, 1, 2)), draw.randrange(61),
                           draw.choice((0.3, 0.8, 2.0))))
    fleet.end()


@pytest.mark.parametrize('seed', range(LIVES))
def test_whatever_happens_each_change_is_told(seed: int) -> None:
    live(seed)
