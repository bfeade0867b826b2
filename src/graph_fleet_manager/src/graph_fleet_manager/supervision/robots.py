"""One robot as the fleet manager knows it: its place, its battery, what keeps it from working."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Collection, List, Optional, Tuple

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.supervision.battery import Battery
from graph_fleet_manager.supervision.edge_times import Driven, EdgeTimer
from graph_fleet_manager.supervision.liveness import ANSWER, SILENCE, Liveness
from graph_fleet_manager.supervision.orders import Heard
from graph_fleet_manager.supervision.outages import Outage, outage_of
from graph_fleet_manager.supervision.reports import NEAR, Place, Pose, Report, place_of
from graph_fleet_manager.supervision.route_client import NewId, RouteClient
from graph_fleet_manager.supervision.route_record import RouteRecord
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteRefusal

AT_VERTEX = 0.02   # m from a vertex at which a robot that follows its edges exactly stands on it
TRIAL = 2.0        # s between two tries to go on after an emergency stop
REFUSALS = 3       # in a row, after which a person must look


@dataclass
class ManagedRobot:
    """One robot; times are those of the supervisor's clock."""

    name: str
    type: RobotType
    settings: RobotSettings
    client: RouteClient
    outage: Optional[Outage] = Outage.UNSEEN
    why: str = ''
    battery: Battery = field(init=False)
    liveness: Liveness = field(default_factory=Liveness)
    is_halted: bool = False
    """It was given an empty route, as all robots are by stop all."""
    comes_to_rest: bool = False
    """Its mission was cancelled or paused: it stops at the end of its edge."""
    dock: Optional[int] = None
    """At which it charges, or to which it is on its way to do so."""
    passed: List[int] = field(default_factory=list)
    """Vertices passed that its mission was not told of yet."""
    driven: List[Driven] = field(default_factory=list)
    """Edges driven of which nothing was learned yet."""
    _timer: EdgeTimer = field(default_factory=EdgeTimer)
    _refusals: int = 0
    _has_refused: bool = False
    """It refused its last order, and where it begins was not considered again yet."""
    _tried: float = -math.inf

    def __post_init__(self) -> None:
        self.battery = Battery(self.settings)

    @property
    def works(self) -> bool:
        """Can it be given something to drive?"""
        return self.outage is None and not self.is_halted

    @property
    def is_charged(self) -> bool:
        """May it be given a mission, as far as its battery is concerned?"""
        return self.dock is None and not self.battery.is_low

    @property
    def place(self) -> Optional[Place]:
        """Where it stands; None while it drives or nobody knows."""
        return self.record.place if self.record.is_standing else None

    @property
    def progress(self) -> Tuple[int, int, bool, bool, Optional[Place]]:
        """All of a report that must outlive a restart: when it changes, it is to be stored."""
        record, client = self.record, self.client
        return record.done, record.end, client.over, client.is_stopping, record.lost_at

    def stands_at(self, vertices: Collection[int]) -> bool:
        """Does it stand on one of these vertices?"""
        return self.place is not None and self.place.vertex in vertices

    def place_at(self, pose: Pose) -> Optional[Place]:
        """Where it can begin a route: on a vertex only if it is as near as it can tell.

        Near a dock it is not docked: it is still to drive there.
        """
        graph = self.record.graph
        place = place_of(pose, graph, min(self.type.play + AT_VERTEX, NEAR))
        return place_of(pose, graph, AT_VERTEX) if _is_dock(place, graph) else place

    @property
    def record(self) -> RouteRecord:
        """What it was given to drive, and how far it is."""
        return self.client.record

    # -- what comes in ----------------------------------------------------------------------------

    def hear(self, report: Report, now: float) -> None:
        """Follows a report that makes sense; who does not know yet where it is, tells nothing."""
        if not report.pose.edge and not report.stamp:
            return
        first = not self.liveness.is_seen
        self.liveness.hear(report, self.record.graph, now)
        if first:
            self.client.adopt(report)
            if self.outage is Outage.UNSEEN:
                self.outage, self.why = None, ''
        if self.outage is Outage.SILENT:
            self.outage, self.why = None, ''
            self.liveness.nothing_to_answer(now)
        if self.outage is Outage.OFF_GRAPH and report.pose.edge and self._was_nowhere:
            self.outage, self.why = None, ''
            self.client.settle(self.place_at(report.pose))
        was_stopped = self.outage is Outage.STOPPED
        heard = self.client.take(report)
        if self.liveness.takes_up(report, self.client.order is not None, now) and (
                self.outage is Outage.DEAF):
            self.outage, self.why = None, ''
        self.passed += heard.passed
        self._judge(heard, report)
        if self.outage is Outage.STOPPED and not was_stopped:
            self._tried = now  # it might take an order yet, for what it knows of its stop
        if self.outage is Outage.LOST_LINK and self.liveness.is_linked_again(report, now):
            self.come_back(self.place_at(report.pose))
        if not self.works:
            self._timer.stop()
        driven = self._timer.follow(self.record, now)
        if driven is not None:
            self.driven.append(driven)

    def drives_on(self, report: Report) -> bool:
        """Does a robot that was left to a person drive what was under way to it by then?"""
        return (self.outage is not None and self.outage.needs_person
                and self.client.drives_withdrawn(report))

    def hear_refusal(self, refusal: RouteRefusal, stamp: float = 0.0) -> bool:
        """An order was not taken up, at `stamp` (s) of the robot's clock; tells whether it is one
        that is still to be answered."""
        heard = self.client.refuse(refusal, stamp)
        self._judge(heard, None)
        return bool(heard.refused)

    def _judge(self, heard: Heard, report: Optional[Report]) -> None:
        if heard.passed:
            self._refusals = 0
        if heard.refused:
            self._has_refused = True
            stopped = outage_of(heard.refused) is Outage.STOPPED
            self._refusals += not (stopped or heard.was_shorter)
            if stopped:
                self.fail(Outage.STOPPED, heard.refused.text)
                self.client.keep_after_refusal()
            elif self._refusals >= REFUSALS:
                self.fail(Outage.FAILED, f'it refused its route {REFUSALS} times: {heard.refused}')
        elif self.outage is Outage.STOPPED and self.client.order is None and not heard.failed and (
                report is not None and report.is_running):
            self.outage, self.why = None, ''
        if self.is_halted:
            return
        if heard.foreign:
            self.fail(Outage.TAKEN_OVER, 'it drives a route that was not given to it here')
        elif heard.failed and self.outage is None:
            self.fail(outage_of(heard.failed), heard.failed.text)
            self.liveness.lose_link(report.stamp if report else 0.0)
        elif report is not None and self.outage is None and not report.pose.edge and (
                self.record.is_standing):
            self.fail(Outage.OFF_GRAPH, 'it reports to be off the graph')
        elif heard.left and self.outage is None:
            self.fail(Outage.TAKEN_OVER, f'it left {self.record.place} without a route')

    def fail(self, outage: Outage, why: str) -> None:
        """Something keeps it from working; what needs a person outlasts what does not."""
        if self.outage is None or not self.outage.needs_person or outage.needs_person:
            self.outage, self.why = outage, why
        if outage.needs_person:
            self.client.withdraw()

    @property
    def _was_nowhere(self) -> bool:
        """Was it never on the graph, so that nothing is blocked for it?"""
        return self.record.place is None and not self.record.held

    # -- the clock --------------------------------------------------------------------------------

    def look(self, now: float) -> None:
        """Finds out that it is silent, or deaf."""
        if self.client.order is None:
            self.liveness.nothing_to_answer(now)
        if self.liveness.is_silent(now) and (
                self.outage in (None, Outage.STOPPED, Outage.DEAF)):
            self.fail(Outage.SILENT, f'it has not reported for {SILENCE:.0f} s')
        elif self.outage is None and self.liveness.is_deaf(now):
            self.fail(Outage.DEAF, f'it reports, but has not answered an order for {ANSWER:.0f} s: '
                                   'do its message definitions differ, or was the clock of the '
                                   'fleet computer set back?')

    def try_after_stop(self, now: float, new_id: NewId, graph: Graph) -> bool:
        """After an emergency stop: what it was driving is ordered anew, until it goes on.

        Tells whether an order is to be sent. A robot that was moved needs a person.
        """
        if self.outage is not Outage.STOPPED or self.is_halted or now - self._tried < TRIAL:
            return False
        if self.client.order is not None or not self.client.is_ready:
            return False
        self._tried = now
        ahead = self.record.ahead
        if not ahead:
            self.outage, self.why = None, ''
            return False
        place = self.place_at(self.record.pose)
        if place is None or not place.touches(graph, ahead[:1], self.type.play):
            self.fail(Outage.TAKEN_OVER, 'it was moved during an emergency stop')
            return False
        self.client.try_again(new_id, 1 if self.comes_to_rest else len(ahead))
        return True

    def begin_elsewhere(self) -> None:
        """After a refusal: what stands near a vertex begins there, or else on the edge it is on.

        How near is near, every robot decides by itself.
        """
        record, client = self.record, self.client
        if not self._has_refused or not client.is_ready or client.order is not None:
            return
        self._has_refused = False
        if not self.works or not record.is_standing or record.place is None:
            return
        vertex = place_of(record.pose, record.graph)
        if vertex is None or vertex.vertex is None or record.pose.fraction in (0.0, 1.0) or (
                _is_dock(vertex, record.graph)):
            return
        client.settle(vertex if record.place.vertex is None else Place(
            edge=record.pose.edge, fraction=record.pose.fraction))

    def go_on_after_stop(self, now: float) -> bool:
        """After stop all, once it has obeyed: it stands where it is; tells whether that is so."""
        if not self.is_halted or self.client.order is not None:
            return False
        if not self.liveness.is_still(now) or self.outage not in (None, Outage.STOPPED):
            return False
        place = self.place_at(self.record.pose)
        held = self.record.held
        self.is_halted = False
        if place is None or (
                held and not place.touches(self.record.graph, held, self.type.play)):
            edges = ', '.join(map(str, held))
            self.fail(Outage.TAKEN_OVER, f'it was stopped on its way over the edges {edges}, but '
                                         f'is {f"at {place}" if place else "off the graph"}')
        else:
            self.client.settle(place)
            self.outage, self.why = None, ''
        return True

    def not_back_yet(self, now: float) -> str:
        """Why a person cannot put it back into service now; empty: they can, or it works."""
        if self.works:
            return ''
        if now - self.liveness.seen > SILENCE or self.outage is Outage.DEAF:
            return f'{self.name} does not report or answer: mend its link first'
        if self.client.order is not None or not self.liveness.is_still(now):
            return (f'{self.name} does not stand still yet, or has a route to drive, or its '
                    'locations are old: try again in a moment')
        return ''

    def come_back(self, place: Optional[Place]) -> str:
        """It works again, from where it is; returns why not, or nothing.

        Without `needs_person` it must stand where it was expected to be.
        """
        if place is None:
            return f'{self.name} is off the graph: bring it onto an edge'
        expected = self.record.held
        if self.outage is Outage.LOST_LINK and expected and not place.touches(
                self.record.graph, expected, self.type.play):
            self.fail(Outage.TAKEN_OVER, f'it was expected elsewhere, but is at {place}')
            return self.why
        self.client.settle(place)
        self.outage, self.why = None, ''
        self.is_halted = False
        self._refusals = 0
        return ''

    def blocked(self) -> Tuple[Tuple[int, ...], Tuple[int, ...]]:
        """Vertices and edges on which it may be while nobody can plan for it."""
        record = self.record
        vertices, edges = set(), {abs(edge) for edge in record.held}
        reported = place_of(record.pose, record.graph) or record.lost_at
        for place in (record.place, reported):
            if place is not None and (not record.ahead or place is not record.place):
                if place.vertex is not None:
                    vertices.add(place.vertex)
                else:
                    edges.add(abs(place.edge))
        return tuple(sorted(vertices)), tuple(sorted(edges))


def _is_dock(place: Optional[Place], graph: Graph) -> bool:
    return place is not None and place.vertex is not None and graph.vertices[place.vertex].dock
