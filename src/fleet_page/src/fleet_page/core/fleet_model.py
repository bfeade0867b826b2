"""The model of the fleet that the page shows. It is the only writer of the live state.

Keys of the live state: `fleet`, `stop`, `counts`, `site`, `closed`, `favourites`, `areas`,
`templates`, `timetables`, `robot:NAME`, `pose:NAME`, `plan:NAME`, `allocation:NAME`, `laser:NAME`,
`resource:NAME`, `machine:NAME`, `mission:ID:STAMP`, `alarm:robot:NAME`, `alarm:mission:ID:STAMP`.
"""
from __future__ import annotations

import math
from collections import Counter, deque
from dataclasses import asdict
from typing import Any, Deque, Dict, Iterable, List, Mapping, Optional, Sequence, Set, Tuple

from fleet_core.supervision.fleet_stop import FleetStop
from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.missions import MissionState
from fleet_page.core.fleet import (
    DEADLINE_ALARMS,
    OPEN_STATES,
    MissionRequest,
    MissionStatus,
    RobotGroup,
    ShownAllocation,
    ShownMachine,
    ShownPlan,
    ShownPose,
    ShownResource,
    ShownRobot,
    ShownTemplate,
    ShownTimetable,
    alarm_of,
    fault_of,
    group_of,
)
from fleet_page.core.live_state import LiveState
from fleet_page.core.records import Sums
from fleet_page.core.robot_events import RobotEvent, event_between
from trajectory_graph import Graph

DEAD_AFTER = 3.0      # s without /fleet_state (2 Hz) after which the fleet manager counts as dead
MOST_ENDED = 200      # ended missions on the page, at most
MOST_REQUESTS = 6000  # requests that are kept for their missions, at most
LONGEST_STEP = 5.0    # m between two poses; a longer step is not counted as driven
LONGEST_GAP = 2.0     # s; a longer time between two states is counted as this time
LEAST_CHANGE = 2.0    # s; a smaller change of a mission's expected end is not shown
SMALL_PART = 0.1      # a change by a smaller part of the time to go is not shown either
HOUR = 3600.0         # s; the page counts the missions that were done in this time
NEEDS_PERSON = 'NEEDS_PERSON'  # state of a mission, and the cause of its alarm

Key = Tuple[int, int]


class FleetModel:
    """Reads the messages of the fleet, writes the state to `live`, and sums up for the history.

    It has one method for each kind of message, because all messages change one shown state.
    """

    def __init__(self) -> None:
        self.live = LiveState()
        self.graph: Optional[Graph] = None
        self.robots: Dict[str, ShownRobot] = {}
        self.places: Dict[str, ShownPose] = {}
        self.missions: Dict[Key, MissionStatus] = {}
        self.ended: Dict[str, int] = {}
        """Missions that ended since the start, by state."""
        self.distance: Dict[str, float] = {}
        """Distance (m) that each robot has driven since the start."""
        self._ends: Dict[Key, float] = {}
        self._requests: Dict[Key, MissionRequest] = {}
        self._sums: Dict[str, Sums] = {}
        self._edge_waiting: Dict[int, float] = {}
        self._heard: Optional[float] = None
        self._numbers: Dict[str, int] = {}
        self._times: Dict[Key, Tuple[Optional[float], Optional[float]]] = {}
        self._done: Deque[float] = deque()
        self._events: List[RobotEvent] = []
        self._faults: Dict[str, Tuple[str, int]] = {}
        self.site_revision = 0
        self.live.put('fleet', {'alive': False, 'heard': None})
        self.live.put('stop', None)
        self.live.put('closed', [])

    # -- the site ---------------------------------------------------------------------------------

    def site_changed(self) -> None:
        """Notes that the site has changed, so that browsers load graph and map again."""
        self.site_revision += 1
        self.live.put('site', self.site_revision)

    def close_edges(self, edges: Iterable[int]) -> None:
        """Shows the edges in the list of all closed edges."""
        self.live.put('closed', sorted(edges))

    def show_resources(self, resources: Iterable[ShownResource],
                       machines: Iterable[ShownMachine] = ()) -> None:
        """Shows all stations, doors and other resources, and all machines."""
        self.live.replace('resource:', {one.name: asdict(one) for one in resources})
        self.live.replace('machine:', {one.name: asdict(one) for one in machines})

    def show_templates(self, templates: Iterable[ShownTemplate]) -> None:
        """Shows all templates of missions."""
        self.live.put('templates', [asdict(one) for one in templates])

    def show_timetables(self, timetables: Iterable[ShownTimetable]) -> None:
        """Shows all timetables."""
        self.live.put('timetables', [asdict(one) for one in timetables])

    def show_named(self, key: str, content: Mapping[str, Any]) -> None:
        """Shows what users have stored by name; `key` is `favourites` or `areas`."""
        self.live.put(key, dict(content))

    # -- robots -----------------------------------------------------------------------------------

    def update_robots(self, robots: Iterable[ShownRobot], now: float) -> None:
        """Updates the model with the states of all robots."""
        found = {robot.name: robot for robot in robots}
        if self._heard is not None:
            self._sum_up(found, min(max(now - self._heard, 0.0), LONGEST_GAP))
        self._heard = now
        for name in found:
            # The number selects the colour; RViz numbers the robots in the same order.
            self._numbers.setdefault(name, len(self._numbers))
        self._show_robots(found, now)
        self._note_events(found, now)
        for name in {*self.robots, *found}:
            self._raise_alarm(f'robot:{name}', alarm_of(found[name]) if name in found else '', now)
        self.robots = found
        self._follow_places()
        self._expect_ends(now)
        self.tick(now)

    def _show_robots(self, robots: Mapping[str, ShownRobot], now: float) -> None:
        self._faults = {name: self._fault_since(robot, now) for name, robot in robots.items()}
        self.live.replace('robot:', {
            name: {**_robot_values(robot), 'number': self._numbers[name],
                   'fault': self._faults[name][0], 'fault_since': self._faults[name][1]}
            for name, robot in robots.items()})

    def _note_events(self, robots: Mapping[str, ShownRobot], now: float) -> None:
        """Notes for each robot the event since its last state, if there was one."""
        happened = (event_between(self.robots[name], robot, now)
                    for name, robot in robots.items() if name in self.robots)
        self._events.extend(event for event in happened if event is not None)

    def _follow_places(self) -> None:
        """Shows a robot without a reported pose at its place on the graph, and forgets the poses of
        robots that are gone."""
        for name in [name for name in self.places if name not in self.robots]:
            del self.places[name]
            self.live.remove(f'pose:{name}')
        for name, robot in self.robots.items():
            place = None if name in self.places else self._place_on_graph(robot)
            if place is not None:
                self._show_place(name, place)

    def _fault_since(self, robot: ShownRobot, now: float) -> Tuple[str, int]:
        """Returns what keeps a robot from working, and since when (s since 1970; 0: nothing)."""
        fault = fault_of(robot)
        known = self._faults.get(robot.name)
        if known is not None and known[0] == fault:
            return known
        return fault, round(now) if fault else 0

    def _expect_ends(self, now: float) -> None:
        """Notes when each mission under way is expected to end.

        Small changes are left out, because they are only noise.
        """
        for key, status in self.missions.items():
            robot = self.robots.get(status.robot)
            if status.state not in OPEN_STATES or robot is None or robot.mission != status.id:
                continue
            before = self._ends.get(key)
            if robot.to_end is None:
                changed = self._ends.pop(key, None) is not None
            else:
                end = now + robot.to_end
                changed = before is None or (
                    abs(end - before) > max(LEAST_CHANGE, SMALL_PART * robot.to_end))
                if changed:
                    self._ends[key] = end
            if changed:
                self._show_mission(key)

    def show_stop(self, stop: FleetStop) -> None:
        """Shows whether the fleet is stopped, even while the fleet manager does not answer."""
        self.live.put('stop', {'cause': stop.cause.name, 'by': stop.by, 'since': stop.since,
                               'why': stop.why} if stop.is_in_force else None)

    def update_places(self, places: Mapping[str, ShownPose]) -> None:
        """Updates the model with the poses of robots."""
        for name, place in places.items():
            before = self.places.get(name)
            if before is not None:
                step = math.hypot(place.x - before.x, place.y - before.y)
                if 0.0 < step < LONGEST_STEP:
                    self.distance[name] = self.distance.get(name, 0.0) + step
                    self._sums.setdefault(name, Sums()).distance += step
            self.places[name] = place
            self._show_place(name, place)

    def tick(self, now: float) -> None:
        """Checks whether the fleet manager still publishes."""
        alive = self._heard is not None and now - self._heard < DEAD_AFTER
        # While the fleet manager publishes, the time is omitted: each message would change it.
        self.live.put('fleet', {'alive': alive, 'heard': None if alive else self._heard})
        while self._done and now - self._done[0] > HOUR:
            self._done.popleft()
        self._count()

    def _count(self) -> None:
        groups = Counter(map(group_of, self.robots.values()))
        self.live.put('counts', {
            **{group.value: groups[group] for group in RobotGroup}, 'done': len(self._done),
            'open': sum(status.state in OPEN_STATES for status in self.missions.values())})

    # -- alarms -----------------------------------------------------------------------------------

    def _raise_alarm(self, alarm: str, cause: str, now: float) -> None:
        """Shows an alarm with a cause; if `cause` is empty, ends the alarm."""
        known = self.live.get(f'alarm:{alarm}')
        if not cause:
            self.live.remove(f'alarm:{alarm}')
        elif known is None or known['cause'] != cause:
            self.live.put(f'alarm:{alarm}', {'cause': cause, 'since': round(now), 'seen_by': ''})

    def acknowledge(self, alarm: str, person: str) -> bool:
        """Notes that a person has seen an alarm. Returns whether the alarm exists."""
        known = self.live.get(f'alarm:{alarm}')
        if known is None:
            return False
        self.live.put(f'alarm:{alarm}', {**known, 'seen_by': known['seen_by'] or person})
        return True

    def _show_place(self, name: str, place: ShownPose) -> None:
        self.live.put(f'pose:{name}', [
            round(place.x, 2), round(place.y, 2),
            None if place.theta is None else round(place.theta, 2)])

    def _place_on_graph(self, robot: ShownRobot) -> Optional[ShownPose]:
        if self.graph is None or abs(robot.edge) not in self.graph.edges:
            return None
        curve = self.graph.curve(robot.edge)
        s = curve.length * min(max(robot.fraction, 0.0), 1.0)
        return ShownPose(*curve.point_at(s), curve.heading_at(s))

    def _sum_up(self, robots: Mapping[str, ShownRobot], seconds: float) -> None:
        for name, robot in robots.items():
            sums = self._sums.setdefault(name, Sums())
            sums.watched += seconds
            if robot.mission is not None:
                sums.busy += seconds
                if robot.is_waiting:
                    sums.waiting += seconds
                    if robot.edge:
                        edge = abs(robot.edge)
                        self._edge_waiting[edge] = self._edge_waiting.get(edge, 0.0) + seconds

    def pop_sums(self) -> Tuple[Dict[str, Sums], Dict[int, float]]:
        """Returns the sums since the last call by robot, and the waiting times (s) by edge."""
        sums, self._sums = self._sums, {}
        edges, self._edge_waiting = self._edge_waiting, {}
        return sums, edges

    def pop_events(self) -> List[RobotEvent]:
        """Returns the events of robots since the last call."""
        events, self._events = self._events, []
        return events

    @property
    def charges(self) -> Dict[str, float]:
        """The charge of each battery whose charge is known, by robot."""
        return {name: robot.battery for name, robot in self.robots.items()
                if robot.battery is not None}

    def moment(self) -> Dict[str, List[Any]]:
        """Returns the present pose and state of all robots, in the form of the replay."""
        values: Dict[str, List[Any]] = {}
        for name, robot in self.robots.items():
            pose = self.live.get(f'pose:{name}')
            if pose is not None:
                values[name] = [*pose, robot.state, robot.waits_for, robot.is_working]
        return values

    # -- plans and missions -----------------------------------------------------------------------

    def update_plans(self, plans: Mapping[str, ShownPlan]) -> None:
        """Shows the plans of all robots."""
        self.live.replace('plan:', {name: [list(plan.edges), plan.released]
                                    for name, plan in plans.items() if plan.edges})

    def show_allocations(self, allocations: Mapping[str, ShownAllocation]) -> None:
        """Shows the allocations of robots; they are empty while no browser shows them."""
        self.live.replace('allocation:', {
            name: [[[edge, round(cleared, 2)] for edge, cleared in one.holds], one.vertex,
                   [[radius, [list(point) for point in line]] for radius, line in one.areas]]
            for name, one in allocations.items()})

    def show_laser(self, robot: str, points: Sequence[int]) -> None:
        """Shows the points of a robot's laser: x and y in cm, one after the other."""
        self.live.put(f'laser:{robot}', list(points))

    def hide_laser(self, robot: str) -> None:
        """Forgets the points of a robot's laser, which no browser shows any more."""
        self.live.remove(f'laser:{robot}')

    def note_request(self, request: MissionRequest) -> None:
        """Keeps the request of a mission, which may come before or after the mission's first
        status.
        """
        key = (request.id, request.stamp)
        self._requests[key] = request
        while len(self._requests) > MOST_REQUESTS:
            del self._requests[next(iter(self._requests))]
        if key in self.missions:
            self._show_mission(key)

    def knows(self, request: MissionRequest) -> bool:
        """Returns whether the same request was noted before."""
        return self._requests.get((request.id, request.stamp)) == request

    @property
    def unknown(self) -> Set[int]:
        """Ids of the open missions with a known status and an unknown request."""
        return {status.id for key, status in self.missions.items()
                if key not in self._requests and status.state in OPEN_STATES}

    def note_history(self, lines: Iterable[HistoryLine]) -> None:
        """Adds requests from the journal that came before the page listened."""
        last = {line.request_id: line for line in lines}
        for key, status in list(self.missions.items()):
            line = last.get(status.id)
            if key not in self._requests and line is not None:
                self._times[key] = line.started, line.ended
                self.note_request(MissionRequest(*key, line.destinations, '', line.robot_type,
                                                 line.priority, line.requested_by))

    def count_done(self, lines: Iterable[HistoryLine], until: float) -> None:
        """Counts the missions in the journal that were done before the page listened."""
        earlier = sorted(line.ended for line in lines if line.state is MissionState.SUCCEEDED
                         and line.ended is not None and line.ended < until)
        self._done.extendleft(reversed(earlier))

    def forget_request(self, id: int) -> None:
        """Forgets a mission's request, because it may have changed: it is read from the journal."""
        for key in [key for key, status in self.missions.items()
                    if key[0] == id and status.state in OPEN_STATES]:
            self._requests.pop(key, None)

    def update_status(self, status: MissionStatus) -> None:
        """Shows the status of a mission."""
        key = (status.id, status.stamp)
        before = self.missions.pop(key, None)
        self.missions[key] = status
        if status.state not in OPEN_STATES and (
                before is None or before.state in OPEN_STATES):
            self.ended[status.state] = self.ended.get(status.state, 0) + 1
            if status.state == 'SUCCEEDED':
                self._done.append(status.told)
        self._note_times(key, before, status)
        self._show_mission(key)
        self._raise_alarm(_name_of(key), NEEDS_PERSON if status.state == NEEDS_PERSON else '',
                          status.told)
        self._count()
        ended = [key for key, known in self.missions.items() if known.state not in OPEN_STATES]
        for old in ended[:-MOST_ENDED]:
            del self.missions[old]
            self._ends.pop(old, None)
            self._times.pop(old, None)
            self.live.remove(_name_of(old))

    def _note_times(self, key: Key, before: Optional[MissionStatus],
                    status: MissionStatus) -> None:
        """Notes when a mission started or ended, if the page got the status of that moment."""
        if before is None or before.state == status.state:
            return
        started, ended = self._times.get(key, (None, None))
        if status.state == 'ACTIVE' and started is None:
            started = status.told
        if status.state not in OPEN_STATES:
            ended = status.told
        self._times[key] = started, ended

    def _show_mission(self, key: Key) -> None:
        status, request = self.missions[key], self._requests.get(key)
        values: Dict[str, Any] = {
            'id': status.id, 'serial': status.serial, 'stamp': status.stamp // 10 ** 9,
            'state': status.state, 'robot': status.robot, 'reached': status.reached,
            'reason': status.reason,
            'asks': str(status.asks) if status.asks else ''}  # a browser would round a number
        for name, time in zip(('started', 'ended'), self._times.get(key, ())):
            if time is not None:
                values[name] = round(time)
        if status.template:
            values['template'] = status.template
        if status.deadline in DEADLINE_ALARMS:
            values['alarm'] = status.deadline
        if request is not None:
            values.update(destinations=list(status.destinations or request.destinations),
                          priority=request.priority, wanted_robot=request.robot,
                          robot_type=request.robot_type, by=request.requested_by)
            end = self._ends.get(key)
            if end is not None and status.state == 'ACTIVE':
                values['ends_at'] = round(end)
        self.live.put(_name_of(key), values)


def _name_of(key: Key) -> str:
    return f'mission:{key[0]}:{key[1]}'


def _robot_values(robot: ShownRobot) -> Dict[str, Any]:
    """Returns the values of a robot for browsers. A value that changes with each report is left
    out or rounded.
    """
    values = asdict(robot)
    for name in ('name', 'edge', 'fraction', 'seen', 'to_end', 'wait'):
        del values[name]
    values.update(alarm=alarm_of(robot), group=group_of(robot).value, works=robot.is_working,
                  asks=robot.needs_person)
    values['battery'] = None if robot.battery is None else round(robot.battery, 2)
    if robot.state in ('OFFLINE', 'ABSENT', 'UNKNOWN', 'OUT_OF_SERVICE'):
        values['seen'] = round(robot.seen)
    return values
