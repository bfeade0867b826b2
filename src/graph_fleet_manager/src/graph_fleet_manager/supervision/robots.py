"""One robot as the fleet manager knows it: its place, its battery and its outage."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Collection, List, Optional

from graph_fleet_manager.fleet import RobotType
from graph_fleet_manager.interlocking.allocation import Knowledge
from graph_fleet_manager.interlocking.orders import Heard
from graph_fleet_manager.interlocking.reports import (
    AT_VERTEX,
    NEAR,
    GraphPosition,
    Pose,
    Report,
    position_of,
)
from graph_fleet_manager.interlocking.route_client import RouteClient
from graph_fleet_manager.interlocking.route_record import RouteRecord
from graph_fleet_manager.supervision.battery import Battery
from graph_fleet_manager.supervision.edge_times import Driven, EdgeTimer
from graph_fleet_manager.supervision.liveness import ANSWER, SILENCE, Liveness
from graph_fleet_manager.supervision.outages import TRANSITIONS, Outage, Sign, sign_of
from graph_fleet_manager.supervision.settings import RobotSettings
from trajectory_graph import Graph
from trajectory_graph.id_lists import listed
from trajectory_graph.route_protocol import RouteRefusal

TRIAL = 2.0        # s between two attempts to go on after an emergency stop
RETRY = 10.0  # s between two orders to a robot that refuses them for its clock or its link
REFUSALS = 3       # number of refusals in a row after which a person must look


@dataclass
class ManagedRobot:
    """One robot of the fleet. Times are those of the supervisor's clock.

    It judges reports, refusals and silence, and keeps the robot's outage. `client` keeps its route
    record and its allocation.
    """

    name: str
    type: RobotType
    settings: RobotSettings
    client: RouteClient
    outage: Optional[Outage] = Outage.UNSEEN
    why: str = ''
    battery: Battery = field(init=False)
    liveness: Liveness = field(default_factory=Liveness)
    is_halted: bool = False
    """It was given an empty route, as each robot is by a fleet stop."""
    comes_to_rest: bool = False
    """Its mission was cancelled or paused: it stops at the end of its edge."""
    dock: Optional[int] = None
    """The dock at which it charges, or to which it drives for charging."""
    passed: List[int] = field(default_factory=list)
    """Vertices that it passed and that are not yet counted for its mission."""
    driven: List[Driven] = field(default_factory=list)
    """Edges that it drove and whose times are not yet learned."""
    _timer: EdgeTimer = field(default_factory=EdgeTimer)
    _refusals: int = 0
    _has_refused: bool = False
    """It refused its last order, and its starting place was not judged again yet."""
    _located: float = -math.inf
    """Time of the last location that was accepted."""
    _tried: float = -math.inf
    _retried: float = -math.inf

    def __post_init__(self) -> None:
        self.battery = Battery(self.settings)

    @property
    def works(self) -> bool:
        """Can the robot be given something to drive?"""
        return self.outage is None and not self.is_halted

    @property
    def is_charged(self) -> bool:
        """Does the battery allow a mission?"""
        return self.dock is None and not self.battery.is_low

    @property
    def needs_person(self) -> bool:
        """May the robot drive only after a person has brought it back?"""
        return self.outage is not None and self.outage.needs_person

    @property
    def is_silent(self) -> bool:
        """Has the robot stopped reporting, so that it may have forgotten its route?"""
        return self.outage is Outage.SILENT

    @property
    def position(self) -> Optional[GraphPosition]:
        """Where the robot stands; None: it drives, or its place is unknown."""
        return self.record.position if self.record.is_standing else None

    def stands_at(self, vertices: Collection[int]) -> bool:
        """Does the robot stand on one of these vertices?"""
        return self.position is not None and self.position.vertex in vertices

    def position_at(self, pose: Pose) -> Optional[GraphPosition]:
        """Where the robot can begin a route if it is at this pose.

        It is on a dock only if it is within AT_VERTEX. A robot near a dock is not docked: it must
        still drive into it.
        """
        graph = self.record.graph
        position = position_of(pose, graph, self.record.near)
        return position_of(pose, graph, AT_VERTEX) if _is_dock(position, graph) else position

    @property
    def record(self) -> RouteRecord:
        """The edges that the robot was ordered to drive, and its progress on them."""
        return self.client.record

    # -- events -----------------------------------------------------------------------------------

    def notice(self, sign: Sign, why: str = '') -> bool:
        """Applies a sign of an outage or of its end. Returns whether the outage changed."""
        sources, target = TRANSITIONS[sign]
        if self.outage not in sources:
            return False
        changes = target is not self.outage
        self.outage, self.why = target, why if target is not None else ''
        if self.needs_person:
            self.client.withdraw()
        return changes

    def hear(self, report: Report, now: float) -> None:
        """Evaluates a report that passed the check. One with neither edge nor stamp is ignored.

        now -- time at which the report arrived
        """
        if not report.pose.edge and not report.stamp:
            return
        if self.client.evidence.is_absent and not self.client.is_back(report, now):
            return
        self.notice(Sign.LOCATED)
        self.liveness.hear(report, self.record.graph, now)
        if self.outage is Outage.SILENT:
            self.liveness.nothing_to_answer(now)
        self.notice(Sign.REPORT)
        if report.pose.edge and self._was_nowhere and self.notice(Sign.FOUND):
            self.client.settle(self.position_at(report.pose))
        was_stopped = self.outage is Outage.STOPPED
        heard = self.client.take(report)
        if self.liveness.takes_up(report, self.client.order is not None, now):
            self.notice(Sign.ANSWER)
        if heard.is_located:
            self._located = now - max(report.age, 0.0)
        self.client.grow(now - self._located)
        self.passed += heard.passed
        self._judge(heard, report)
        if self.outage is Outage.STOPPED and not was_stopped:
            # the robot may still take up an order, because it does not know of its stop yet
            self._tried = now
        if self.outage is Outage.LOST_LINK and self.client.withdrawn is None and (
                self.client.order is None and now - self._retried > RETRY
                and self.liveness.is_linked_again(report, now)):
            self._link_is_back()
        if not self.works:
            self._timer.stop()
        driven = self._timer.follow(self.record, now)
        if driven is not None:
            self.driven.append(driven)

    def must_stop(self, report: Report, now: float) -> bool:
        """Must the robot be stopped because an order was on its way when it dropped out?

        - A robot that needs a person is stopped if it drives that order.
        - A robot whose link is back is stopped because that order may still reach it.
        """
        if self.needs_person:
            return self.client.drives_withdrawn(report)
        return (self.outage is Outage.LOST_LINK and self.client.withdrawn is not None
                and not self.client.is_stopping and self.liveness.is_linked_again(report, now))

    def hear_refusal(self, refusal: RouteRefusal, stamp: float = 0.0) -> bool:
        """The robot refused an order at `stamp` (s) of its clock. Returns whether it was pending.
        """
        heard = self.client.refuse(refusal, stamp)
        self._judge(heard, None)
        return bool(heard.refused)

    def _judge(self, heard: Heard, report: Optional[Report]) -> None:
        if heard.passed:
            self._refusals = 0
        if heard.refused:
            self._follow_refusal(heard)
        elif self.client.order is None and not heard.failed and (
                report is not None and report.is_running):
            self.notice(Sign.DRIVES)
        if not self.is_halted:
            self._judge_motion(heard, report)
        if self.client.clock_is_off:
            self.notice(Sign.CLOCK_OFF, 'its clock is ahead of the fleet computer\'s: correct the '
                                        'time of both (NTP)')
        elif self.liveness.seen - self._retried > RETRY:
            self.notice(Sign.CLOCK_RIGHT)

    def _judge_motion(self, heard: Heard, report: Optional[Report]) -> None:
        if heard.foreign:
            self.notice(Sign.TAKEN, 'it drives a route that was not given to it here')
        elif heard.failed and self.outage is None:
            self.notice(sign_of(heard.failed), heard.failed.text)
            self.liveness.lose_link()
        elif report is not None and not report.pose.edge and self.record.is_standing and (
                self.client.evidence.is_confirmed):
            self.notice(Sign.LEFT_GRAPH, 'it reports that it is off the graph')
        elif heard.left and self.outage is None:
            self.notice(Sign.TAKEN, f'it left {self.record.position} without a route')

    def _follow_refusal(self, heard: Heard) -> None:
        self._has_refused = True
        sign = sign_of(heard.refused)
        if sign in (Sign.CLOCK_OFF, Sign.LINK_LOST):
            self._retried = self.liveness.seen
            self.notice(sign, heard.refused.text)
            self.liveness.lose_link()
            return
        self._refusals += not (sign is Sign.EMERGENCY or heard.was_shorter)
        if sign is Sign.EMERGENCY:
            self.notice(sign, heard.refused.text)
            self.client.keep_after_refusal()
        elif self._refusals >= REFUSALS:
            self.notice(Sign.FAILURE,
                        f'it refused its route {REFUSALS} times: {heard.refused}')

    @property
    def _was_nowhere(self) -> bool:
        """Was the robot never on the graph?"""
        return self.record.position is None and not self.record.held

    # -- time -------------------------------------------------------------------------------------

    def look(self, now: float, heard: float) -> None:
        """Detects that the robot is silent or deaf, and that its last location gets old.

        heard -- time until which all arrived reports were evaluated
        """
        if self.client.order is None or self.client.is_new_motion:  # a new order waits for the disk
            self.liveness.nothing_to_answer(now)
        if self.liveness.is_silent(heard):
            self.notice(Sign.SILENCE, f'it has not reported for {SILENCE:.0f} s')
        elif self.outage is None and self.liveness.is_deaf(heard):
            self.notice(Sign.NO_ANSWER, f'it reports, but has not answered an order for '
                        f'{ANSWER:.0f} s: do its message definitions differ, or was the clock of '
                        'the fleet computer set back?')
        if self.liveness.is_seen:
            self.client.grow(heard - self._located)

    def wants_to_go_on(self, now: float) -> int:
        """Number of edges to order anew after an emergency stop; 0: none now.

        A robot that was moved during the stop needs a person.
        """
        if self.outage is not Outage.STOPPED or self.is_halted or now - self._tried < TRIAL:
            return 0
        if self.client.order is not None or not self.client.is_ready:
            return 0
        self._tried = now
        ahead = self.record.ahead
        if not ahead:
            self.notice(Sign.DRIVES)
            return 0
        position = self.position_at(self.record.pose)
        if position is None or not position.touches(self.record.graph, ahead[:1], self.type.play):
            self.notice(Sign.TAKEN, 'it was moved during an emergency stop')
            return 0
        return 1 if self.comes_to_rest else len(ahead)

    def other_beginning(self) -> Optional[GraphPosition]:
        """Another starting place to be tried after a refusal; None: there is none.

        Each robot decides by itself how near to a vertex it must be. So a robot near a vertex is
        now settled on the vertex if it counted as on its edge, and on its edge otherwise.
        """
        record, client = self.record, self.client
        if not self._has_refused or not client.is_ready or client.order is not None:
            return None
        self._has_refused = False
        if not self.works or not record.is_standing or record.position is None:
            return None
        vertex = position_of(record.pose, record.graph, NEAR)
        if vertex is None or vertex.vertex is None or record.pose.fraction in (0.0, 1.0) or (
                _is_dock(vertex, record.graph)):
            return None
        return vertex if record.position.vertex is None else GraphPosition(
            edge=record.pose.edge, fraction=record.pose.fraction)

    def go_on_after_stop(self, now: float) -> bool:
        """After an obeyed fleet stop: settles the robot where it stands. Returns whether it did."""
        if not self.is_halted or self.client.order is not None:
            return False
        if not self.liveness.is_still(now) or self.outage not in (None, Outage.STOPPED):
            return False
        self.is_halted = False
        self._settle_where_expected(Sign.STANDS)
        return True

    def _link_is_back(self) -> None:
        if self._settle_where_expected(Sign.LINK_BACK):
            self._refusals = 0

    def _settle_where_expected(self, sign: Sign) -> bool:
        """Settles a standing robot if it is on what it holds. Otherwise a person moved it.

        sign -- the sign to notice if it is on what it holds
        """
        position, held = self.position_at(self.record.pose), self.record.held
        if position is not None and (
                not held or position.touches(self.record.graph, held, self.type.play)):
            self.client.settle(position)
            self.notice(sign)
            return True
        whereabouts = f'at {position}' if position else 'off the graph'
        self.notice(Sign.TAKEN, 'it was expected on the edges '
                                f'{listed(held)}, but is {whereabouts}')
        return False

    # -- commands of people -----------------------------------------------------------------------

    def not_back_yet(self, now: float) -> str:
        """Why a person cannot put it back into service now; empty: it is possible, or it works."""
        if self.works:
            return ''
        if self.outage is Outage.ABSENT:
            return f'{self.name} was declared absent: switch it on, and it is back'
        if now - self.liveness.seen > SILENCE or self.outage is Outage.DEAF:
            return f'{self.name} does not report or answer: repair its link first'
        if self.client.order is not None or not self.liveness.is_still(now):
            return (f'{self.name} does not stand still yet, or has a route to drive, or its '
                    'locations are old: try again in a moment')
        return ''

    def come_back(self) -> str:
        """A person says that it works again, from where it is. Returns why not; empty: done."""
        position = self.position_at(self.record.pose)
        if position is None:
            return f'{self.name} is off the graph: bring it onto an edge'
        self.client.settle(position)
        self.notice(Sign.BROUGHT_IN)
        self.is_halted = False
        self._refusals = 0
        return ''

    def declare_absent(self, now: float) -> str:
        """A person says that it is not on the site. Returns why that cannot be; empty: done."""
        if self.liveness.is_seen and now - self.liveness.seen <= SILENCE:
            return f'{self.name} reports: switch it off first'
        self.client.declare_absent(now)
        self.notice(Sign.DECLARED_ABSENT, 'it was declared absent')
        self.is_halted = self.comes_to_rest = False
        self.dock = None
        self.liveness = Liveness()
        return ''

    @property
    def knowledge(self) -> Knowledge:
        """What is known of the robot's place."""
        return self.client.allocation.knowledge


def _is_dock(position: Optional[GraphPosition], graph: Graph) -> bool:
    return (position is not None and position.vertex is not None
            and graph.vertices[position.vertex].dock)
