"""Stations: robots wait in a queue, enter the station in order, and leave its exit free."""
from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import Any, Dict, List, Mapping, Optional

import pytest
from fleet_builders import AGV, graph_of
from proofs import LONG, is_whole

from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.missions import CommandKind, MissionChange, MissionState, Request
from fleet_core.supervision.resource_view import ResourceView, resource_views
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.station_desk import QueuePlace
from fleet_core.supervision.waits import WaitCode
from fleet_core.supervision.why import mission_reason
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station, StationKind
from fleet_core.work.stops import When, WorkStep, WorkStop, dwells_of
from fleet_core.work.templates import Template, TemplateStop
from fleet_simulation.agv.steps import SimulatedSteps
from trajectory_graph import Graph
from world.plain_agv import Agv
from world.supervised_fleet import SupervisedFleet

LIVES = 40 if LONG else 12 if is_whole(__file__) else 1
STAY = 12.0  # s; time that a robot works at a place


class FleetAtStations(SupervisedFleet):
    """A fleet that checks in each step that no station contains more robots than its capacity.

    It also records the order of arrivals.
    """

    def __init__(self, graph: Graph, robots: Mapping[str, int], *stations: Station,
                 **more: Any) -> None:
        self.stations = {one.name: one for one in stations}
        templates = more.pop('templates', {})
        self.arrived: List[str] = []
        """Robots that came to rest at a place of a station, in order."""
        self.queued: List[str] = []
        """Robots that came to rest at a queue place, in order; a robot may occur several times."""
        self._was: Dict[str, Optional[int]] = {}
        more.setdefault('settings', RobotSettings(release_ahead=3.0))
        super().__init__(
            graph, {name: (AGV, vertex) for name, vertex in robots.items()},
            work=SiteWork(self.stations, templates=templates), **more)

    def step(self) -> None:
        super().step()
        for station in self.stations.values():
            inside = [name for name, agv in self.agvs.items() if self._is_inside(agv, station)]
            assert len(inside) <= station.capacity, self.picture()
        for name in self.agvs:
            self._note(name)

    def _is_inside(self, agv: Agv, station: Station) -> bool:
        return any(math.dist(agv.position, self.graph.vertex(place).position) < 0.5
                   for place in station.places)

    def _note(self, name: str) -> None:
        robot = self.supervisor.robots[name]
        at = robot.position.vertex if robot.position and not robot.record.ahead else None
        if at != self._was.get(name) and at is not None:
            mission = self.supervisor.book.of_robot(name)
            for station in self.stations.values():
                is_to_station = mission is not None and mission.left[:1] and (
                    mission.left[0] in station.places)
                if at in station.places and is_to_station:
                    self.arrived.append(name)
                elif at in station.queue and is_to_station:
                    self.queued.append(name)
        self._was[name] = at

    def visit(self, id: int, place: int, *then: int, **more: Any) -> None:
        """Sends a mission that stays at a place of a station."""
        self.request(id, place, *then, dwells=(STAY, *(0.0 for _ in then)), **more)

    def line(self, station: Station) -> List[str]:
        """Returns the robots at the queue places of a station, in the order of the places."""
        at = {robot.position.vertex: name for name, robot in self.supervisor.robots.items()
              if robot.position is not None}
        return [at[place] for place in station.queue if place in at]


# A press at the end of a lane with its queue, and an exit on the other side:
#
#     11 -- 12 -- 13 -- 14 -- 15 -- 16
#      |     |     |     |     |     |
#      1 --- 2 --- 3 --- 4 --- 5 -- 18 (press)      queue: 5, 4, 3
LANE = graph_of(
    {**{k: (2.0 * k, 0.0) for k in (1, 2, 3, 4, 5)}, 18: (12.0, 0.0),
     **{10 + k: (2.0 * k, 3.0) for k in (1, 2, 3, 4, 5, 6)}},
    {**{k: (k, k + 1) for k in (1, 2, 3, 4)}, 5: (5, 18), 6: (18, 16),
     **{10 + k: (10 + k, 11 + k) for k in (1, 2, 3, 4, 5)},
     **{20 + k: (k, 10 + k) for k in (1, 2, 3, 4, 5)}})
PRESS = Station('press', (18,), (5, 4, 3))
STARTS = {'a': 1, 'b': 2, 'c': 11, 'd': 12, 'e': 13}
PARKING = (1, 2, 11, 12, 13, 14, 15)


def lane(count: int, station: Station = PRESS, **more: Any) -> FleetAtStations:
    starts = dict(list(STARTS.items())[:count])
    fleet = FleetAtStations(LANE, starts, station, parking=PARKING, **more)
    fleet.run(2.0)
    return fleet


def test_a_robot_waits_at_the_first_queue_place_while_the_station_is_busy() -> None:
    fleet = lane(2)
    fleet.visit(1, 18, robot='b')
    fleet.run_until(lambda: fleet.arrived == ['b'])
    fleet.visit(2, 18, robot='a')
    fleet.run_until(lambda: fleet.queued == ['a'], limit=STAY - 1.0)
    assert fleet.supervisor.robots['a'].position.vertex == 5
    assert shown(fleet).queue == (QueuePlace(5, 'a', True), QueuePlace(4), QueuePlace(3))
    fleet.run_until_done(1, 2)
    assert shown(fleet).queue == (QueuePlace(5), QueuePlace(4), QueuePlace(3))


def test_a_queue_place_is_of_a_robot_from_when_it_sets_out() -> None:
    fleet = lane(2)
    fleet.visit(1, 18, robot='b')
    fleet.visit(2, 18, robot='a')
    fleet.run_until(lambda: bool(shown(fleet).queue[0].robot))
    assert shown(fleet).queue[0] == QueuePlace(5, 'a', False)
    assert not shown(fleet).is_group


def shown(fleet: FleetAtStations) -> ResourceView:
    view, = resource_views(fleet.supervisor, fleet.now)
    return view


def test_robots_fill_the_queue_in_order_and_are_served_in_that_order() -> None:
    fleet = lane(4)
    for id in range(1, 5):
        fleet.visit(id, 18, 11)
    fleet.run_until(lambda: len(fleet.line(PRESS)) == 3)
    line = fleet.line(PRESS)
    fleet.run_until_done(1, 2, 3, 4)
    assert fleet.arrived[1:] == line


SHORT = Station('press', (18,), (5,))


def full_press() -> FleetAtStations:
    """Returns three robots. Two of them occupy the press and its queue; mission 3 also leads to
    the press.
    """
    fleet = lane(3, SHORT)
    for id, name in enumerate('ba', 1):
        fleet.visit(id, 18, robot=name)
    fleet.run_until(lambda: fleet.queued == ['a'])
    fleet.visit(3, 18)
    fleet.run(2.0)
    return fleet


def test_a_mission_to_a_full_station_gets_no_robot_that_would_only_stand_in_the_way() -> None:
    fleet = full_press()
    mission = fleet.supervisor.book.find(3)
    assert (mission.state, mission.robot) == (MissionState.PENDING, '')
    fleet.request(4, 14)
    fleet.run_until_done(4)
    assert fleet.supervisor.book.find(4).robot == 'c'
    fleet.run_until_done(1, 2, 3)
    assert fleet.arrived[:2] == ['b', 'a']


def test_why_a_mission_gets_no_robot_names_the_full_station_and_who_is_there() -> None:
    fleet = full_press()
    mission = fleet.supervisor.book.find(3)
    told = mission_reason(mission, fleet.supervisor, fleet.now)
    assert told.wait.code is WaitCode.RESOURCE
    assert told.wait.text == mission.reason == (
        'station press is full with its queue: it waits for one of b, a to leave')
    assert 0.0 < told.wait.until <= STAY
    assert {one.robot: one.hindrance for one in told.robots} == {
        'a': Hindrance.BUSY, 'b': Hindrance.BUSY, 'c': Hindrance.FULL}
    assert 'station' in told.robots[2].text


def test_a_mission_to_a_full_station_gets_a_robot_when_the_queue_moves_up() -> None:
    fleet = full_press()
    fleet.run_until(lambda: bool(fleet.supervisor.book.find(3).robot))
    assert fleet.supervisor.book.find(1).state is MissionState.SUCCEEDED
    assert fleet.supervisor.book.find(2).state.is_open


def test_a_robot_in_the_station_gets_no_further_mission_there_while_others_wait() -> None:
    fleet = lane(3)
    fleet.visit(1, 18, robot='b')
    fleet.visit(2, 18, robot='a')
    fleet.run_until(lambda: fleet.queued == ['a'])
    fleet.run_until_done(1)
    fleet.visit(3, 18, robot='b')
    fleet.visit(4, 18)
    fleet.run_until_done(2, 3, 4)
    assert fleet.arrived[:2] == ['b', 'a']


def test_missions_that_come_together_get_no_more_robots_than_the_station_and_its_queue_hold(
        ) -> None:
    fleet = lane(4, SHORT)
    for id in range(1, 5):
        fleet.visit(id, 18)
    fleet.run(1.0)
    robots = [fleet.supervisor.book.find(id).robot for id in range(1, 5)]
    assert all(robots[:2]) and robots[2:] == ['', '']
    fleet.run_until_done(1, 2, 3, 4)


def test_a_robot_without_work_in_a_station_does_not_make_it_full() -> None:
    fleet = lane(2, Station('press', (18,)))
    fleet.visit(1, 18, robot='b')
    fleet.run_until_done(1)
    fleet.visit(2, 18, robot='a')
    fleet.run_until_done(2)


def test_a_station_in_which_a_robot_cannot_work_gets_only_robots_for_its_queue() -> None:
    fleet = lane(3, SHORT)
    fleet.visit(1, 18, robot='b')
    fleet.run_until(lambda: fleet.arrived == ['b'])
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.visit(2, 18)
    fleet.visit(3, 18)
    fleet.run(2.0)
    assert fleet.supervisor.book.find(2).robot and not fleet.supervisor.book.find(3).robot


def test_a_robot_on_a_longer_mission_for_which_the_queue_is_full_waits_where_it_is() -> None:
    fleet = lane(3, SHORT)
    fleet.request(3, 14, 18, dwells=(0.0, 1.0), robot='c')
    for id, name in enumerate('ba', 1):
        fleet.visit(id, 18, robot=name)
    fleet.run_until(lambda: fleet.queued == ['a'] and fleet.supervisor.book.find(3).reached == 1)
    fleet.run(2.0)
    place = fleet.agvs['c'].position
    fleet.run(3.0)
    assert fleet.agvs['c'].position == place
    mission = fleet.supervisor.book.find(3)
    assert mission_reason(mission, fleet.supervisor, fleet.now).wait.text.startswith(
        'its turn at station press, which is full with its queue: ')
    fleet.run_until_done(1, 2, 3)
    assert fleet.arrived == ['b', 'a', 'c']


def test_a_robot_without_work_leaves_the_station_when_another_one_waits() -> None:
    fleet = lane(2)
    fleet.visit(1, 18, robot='b')
    fleet.run_until_done(1)
    fleet.run(5.0)
    assert fleet.supervisor.robots['b'].position.vertex == 18
    fleet.visit(2, 18, robot='a')
    fleet.run_until_done(2)
    assert fleet.supervisor.robots['b'].position.vertex in PARKING


def test_a_robot_that_is_brought_in_on_the_way_out_of_a_station_leaves_though_another_claims_it(
) -> None:
    fleet = lane(3)
    fleet.do(fleet.supervisor.take_out('c', fleet.now))
    fleet.visit(1, 18, robot='b')
    fleet.run_until(lambda: fleet.arrived == ['b'])
    fleet.visit(2, 18, robot='a')
    fleet.agvs['c'].be_carried(6, 0.8 * LANE.curve(6).length)
    fleet.run_until(lambda: fleet.queued == ['a'])
    fleet.visit(3, 11, robot='c')
    assert not fleet.bring_in('c')
    fleet.run_until(lambda: fleet.agvs['c'].visited[-1] == 16, limit=4.0)
    assert fleet.state(1) is MissionState.ACTIVE and fleet.supervisor.stations.inside(
        'press') == ['b']
    fleet.run_until_done(1, 2, 3)


def test_a_robot_that_has_its_next_stop_at_the_same_station_stays_there() -> None:
    fleet = lane(2)
    fleet.request(1, 18, 18, dwells=(STAY, STAY), robot='b')
    fleet.visit(2, 18, robot='a')
    fleet.run_until_done(1, 2)
    assert fleet.arrived == ['b', 'a']


def test_a_robot_does_not_pass_its_last_stop_before_a_busy_station() -> None:
    fleet = lane(3)
    fleet.visit(1, 18, robot='b')
    fleet.run_until(lambda: fleet.arrived == ['b'])
    fleet.request(2, 14, 18, dwells=(0.0, 1.0), robot='c')
    fleet.visit(3, 18, robot='a')
    fleet.run_until_done(1, 2, 3)


def test_a_cancelled_robot_leaves_the_queue_and_the_others_move_up() -> None:
    fleet = lane(3)
    for id, name in enumerate('bac', 1):
        fleet.visit(id, 18, robot=name)
    fleet.run_until(lambda: fleet.line(PRESS) == ['a', 'c'])
    fleet.do(fleet.supervisor.command(2, CommandKind.CANCEL, fleet.now))
    fleet.run_until_done(1, 3)
    assert fleet.arrived == ['b', 'c']


def test_the_queue_keeps_its_order_over_a_restart() -> None:
    fleet = lane(4)
    for id, name in enumerate('bacd', 1):
        fleet.visit(id, 18, robot=name)
    fleet.run_until(lambda: len(fleet.line(PRESS)) == 3)
    line = fleet.line(PRESS)
    fleet.restart()
    fleet.run_until_done(1, 2, 3, 4)
    assert fleet.arrived[1:] == line


def test_a_robot_in_the_queue_says_for_whom_it_waits_and_until_when() -> None:
    fleet = lane(3)
    for id, name in enumerate('bac', 1):
        fleet.visit(id, 18, robot=name)
    fleet.run_until(lambda: fleet.line(PRESS) == ['a', 'c'] and fleet.arrived == ['b'])
    mission = fleet.supervisor.book.find(3)
    wait = mission_reason(mission, fleet.supervisor, fleet.now).wait
    assert wait.code is WaitCode.RESOURCE
    assert wait.text == 'its turn at station press, after b, a'
    assert 0.0 < wait.until <= STAY


def test_the_steps_before_the_entry_do_not_begin_before_the_turn() -> None:
    fleet = lane(2)
    fleet.steps['a'] = SimulatedSteps(lambda: 1)
    fleet.visit(1, 18, robot='b')
    fleet.run_until(lambda: fleet.arrived == ['b'])
    knock = WorkStep('knock', 20.0, when=When.BEFORE_ENTRY)
    stops = (WorkStop(18, steps=(knock,)),)
    fleet.request(2, 18, stops=stops, dwells=dwells_of(stops), robot='a')
    fleet.run_until(lambda: fleet.line(PRESS) == ['a'])
    fleet.run(2.0)
    assert fleet.arrived == ['b'] and not fleet.supervisor.book.find(2).has_worked
    fleet.run_until_done(1, 2)


SHELVES = Station('shelves', (13, 14, 15), (11,), 3, StationKind.GROUP)
ENGAGE = WorkStep('engage', 60.0)
FETCH = Template('fetch', (), (TemplateStop('shelves', steps=(ENGAGE,)),))


def at_shelves(count: int, station: Station = SHELVES) -> FleetAtStations:
    """Robots that carry out a step at any one of three shelves."""
    fleet = lane(count, station, templates={'fetch': FETCH})
    fleet.steps = {name: SimulatedSteps(lambda: 1) for name in fleet.agvs}
    return fleet


def shelf(fleet: FleetAtStations, id: int) -> int:
    return fleet.supervisor.book.find(id).request.destinations[0]


def test_robots_at_a_group_never_go_to_one_place() -> None:
    fleet = at_shelves(3)
    for id, name in enumerate('abc', 1):
        fleet.do(fleet.supervisor.request(Request(id, (), template='fetch', robot=name), fleet.now))
    fleet.run(3.0)
    assert {shelf(fleet, id) for id in (1, 2, 3)} == {13, 14, 15}
    fleet.run_until_done(1, 2, 3)


def test_the_places_of_a_group_are_told_as_equal() -> None:
    assert shown(at_shelves(1)).is_group


def test_a_request_without_a_template_may_name_a_group() -> None:
    fleet = at_shelves(3)
    stops = (WorkStop(0, steps=(ENGAGE,), group='shelves'),)
    for id, name in enumerate('abc', 1):
        fleet.request(id, 0, stops=stops, dwells=dwells_of(stops), robot=name)
    fleet.request(1, 0, stops=stops, dwells=dwells_of(stops), robot='a')  # sent again
    fleet.run(3.0)
    assert {shelf(fleet, id) for id in (1, 2, 3)} == {13, 14, 15}
    fleet.run_until_done(1, 2, 3)
    assert len(fleet.supervisor.book.open) == 0


def test_a_change_may_name_a_group() -> None:
    fleet = at_shelves(1)
    stops = (WorkStop(1, steps=(ENGAGE,)), WorkStop(2))
    fleet.request(1, 1, 2, stops=stops, dwells=dwells_of(stops))
    change = MissionChange(0, stops=(WorkStop(0, group='shelves'),), first_stop=2)
    fleet.do(fleet.supervisor.command(1, CommandKind.MODIFY, fleet.now, change))
    fleet.run_until_done(1)
    assert fleet.supervisor.robots['a'].position.vertex == 13


@pytest.mark.parametrize('group', ['press', 'shelf', '18'])
def test_a_request_for_an_unknown_group_is_refused(group: str) -> None:
    fleet = at_shelves(1)
    fleet.request(1, 0, stops=(WorkStop(0, group=group),))
    assert fleet.told(1)[-1] is MissionState.REFUSED
    assert fleet.statuses[-1].reason == (
        f"there is no group '{group}'; there are: shelves")


def test_the_nearest_free_place_is_chosen_when_the_robot_may_go() -> None:
    one_at_a_time = replace(SHELVES, capacity=1)
    fleet = at_shelves(2, one_at_a_time)
    for id, name in enumerate('ab', 1):
        fleet.do(fleet.supervisor.request(Request(id, (), template='fetch', robot=name), fleet.now))
    first_choice = shelf(fleet, 2)
    fleet.run_until_done(1, 2)
    assert (first_choice, shelf(fleet, 2)) == (14, 13)


def test_another_place_is_chosen_while_a_robot_that_cannot_work_stands_in_the_first_one() -> None:
    fleet = FleetAtStations(LANE, {'a': 1, 'b': 13}, SHELVES, parking=PARKING,
                            templates={'fetch': FETCH})
    fleet.steps = {name: SimulatedSteps(lambda: 1) for name in fleet.agvs}
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.do(fleet.supervisor.request(Request(1, (), template='fetch', robot='a'), fleet.now))
    assert shelf(fleet, 1) == 13
    fleet.restart()
    fleet.run_until_done(1)
    assert shelf(fleet, 1) == 14


# Two stations without a queue: each robot stands at the station that the other robot needs.
def test_two_robots_that_want_each_others_stations_make_room() -> None:
    fleet = FleetAtStations(LANE, {'a': 1, 'b': 12}, Station('press', (18,)),
                            Station('table', (3,)), parking=PARKING)
    fleet.run(2.0)
    fleet.request(1, 18, 3, dwells=(STAY, 1.0), robot='a')
    fleet.request(2, 3, 18, dwells=(STAY, 1.0), robot='b')
    fleet.run_until_done(1, 2)


# The press at the end of a dead end. The only path away from the press leads through its queue.
DEAD_END = graph_of({vertex.id: vertex.position for vertex in LANE.vertices.values()},
                    {edge.id: (edge.origin, edge.destination) for edge in LANE.edges.values()
                     if edge.id != 6})


def test_robots_in_a_queue_make_room_where_it_is_the_only_way_out() -> None:
    fleet = FleetAtStations(DEAD_END, {'a': 1, 'b': 2, 'c': 11, 'd': 12}, PRESS, parking=PARKING)
    fleet.run(2.0)
    for id in range(1, 7):
        fleet.visit(id, 18, 11)
    fleet.run_until_done(*range(1, 7), limit=900.0)
    assert len(fleet.arrived) == 6


@pytest.mark.parametrize('seed', range(LIVES))
def test_many_missions_at_one_station_all_end_and_each_is_served_once(seed: int) -> None:
    draw = Random(seed)
    fleet = lane(5, seed=seed)
    ids = range(1, 13)
    for id in ids:
        fleet.visit(id, 18, draw.choice((1, 11, 14)))
        if id % 3 == 0:
            fleet.run(draw.uniform(0.0, 20.0))
    fleet.run_until_done(*ids, limit=900.0)
    assert len(fleet.arrived) == len(ids)


@pytest.mark.parametrize('seed', range(LIVES))
def test_all_missions_end_although_robots_break_down_and_the_fleet_manager_dies(seed: int) -> None:
    draw = Random(seed)
    fleet = lane(4, seed=seed)
    ids = range(1, 9)
    for id in ids:
        fleet.visit(id, 18, draw.choice((1, 11, 14)))
    for _ in range(4):
        fleet.run(draw.uniform(5.0, 25.0))
        name = draw.choice(sorted(fleet.agvs))
        fleet.do(fleet.supervisor.take_out(name, fleet.now))
        fleet.run(draw.uniform(5.0, 25.0))
        if draw.random() < 0.5:
            fleet.restart()
            fleet.run(2.0)
        while fleet.bring_in(name):
            fleet.run(1.0)
    fleet.run_until(lambda: not fleet.supervisor.book.open, limit=900.0)
