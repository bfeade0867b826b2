"""One robot as the fleet manager knows it: its place, its battery and its outage."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Collection, List, Optional

from fleet_core.fleet import NEAR, RobotType
from fleet_core.interlocking.allocation import Knowledge
from fleet_core.interlocking.reports import GraphPosition, Report, position_of
from fleet_core.interlocking.route_master import BESIDE, Heard, RouteMaster, is_dock
from fleet_core.interlocking.route_record import RouteRecord
from fleet_core.supervision.battery import Battery
from fleet_core.supervision.edge_times import Driven, EdgeTimer
from fleet_core.supervision.liveness import ANSWER, SILENCE, Liveness
from fleet_core.supervision.outages import (
    TRANSITIONS,
    Outage,
    Sign,
    sign_of,
    sign_of_epoch,
    words_of,
)
from fleet_core.supervision.settings import RobotSettings
from route_protocol.values import Motion, ReasonCode

RETRY = 10.0  # s between two orders to a robot that refuses them because of its clock or its link
REFUSALS = 3       # number of consecutive refusals after which a person must look


@dataclass
class ManagedRobot:
    """One robot of the fleet. Times are those of the supervisor's clock.

    It judges reports, refusals and silence, and keeps the robot's outage. `master` keeps its route
    record and its allocation.

    It has one method for each event of a robot and one for each question about it.
    """

    name: str
    type: RobotType
    settings: RobotSettings
    master: RouteMaster
    outage: Optional[Outage] = Outage.UNSEEN
    why: str = ''
    battery: Battery = field(init=False)
    liveness: Liveness = field(default_factory=Liveness)
    is_halted: bool = False
    """It was given an empty route, for example by a fleet stop."""
    comes_to_rest: bool = False
    """Its mission was cancelled or paused: it stops at the end of its edge."""
    dock: Optional[int] = None
    """The place of a charger for which it has a turn (`charging`)."""
    charge_until: float = 0.0
    """Charge (0..1) that it was asked to reach; 0: it was not asked."""
    tops_up: bool = False
    """It charges only because it has nothing to do: it gives up its turn for other robots or work.
    """
    passed: List[int] = field(default_factory=list)
    """Vertices that it passed, but that are not yet counted for its mission."""
    driven: List[Driven] = field(default_factory=list)
    """Edges that it drove, but whose times are not yet learned."""
    _timer: EdgeTimer = field(default_factory=EdgeTimer)
    _refusals: int = 0
    _has_refused: bool = False
    """It has refused its last order, and `other_beginning` was not read since."""
    _located: float = -math.inf
    """Time of the last location that was accepted."""
    _unready: ReasonCode = ReasonCode.NONE
    """Why the robot would refuse each route, according to its last report."""
    _retried: float = -math.inf

    def __post_init__(self) -> None:
        self.battery = Battery(self.settings)

    @property
    def works(self) -> bool:
        """Whether the robot can be given something to drive."""
        return self.outage is None and not self.is_halted

    @property
    def is_charged(self) -> bool:
        """Whether the battery allows a mission."""
        return not (self.battery.is_low or self.charge_until
                    or self.dock is not None and not self.tops_up)

    @property
    def needs_person(self) -> bool:
        """Whether the robot may drive only after a person has brought it back."""
        return self.outage is not None and self.outage.needs_person

    @property
    def position(self) -> Optional[GraphPosition]:
        """Where the robot stands; None: it drives, or its place is unknown."""
        return self.record.position if self.record.is_standing else None

    def stands_at(self, vertices: Collection[int]) -> bool:
        """Returns whether the robot stands on one of these vertices."""
        return self.position is not None and self.position.vertex in vertices

    @property
    def record(self) -> RouteRecord:
        """The edges that the robot was ordered to drive, and its progress on them."""
        return self.master.record

    # -- events -----------------------------------------------------------------------------------

    def notice(self, sign: Sign, why: str = '') -> bool:
        """Applies a sign, which may begin or end an outage. Returns whether the outage changed."""
        sources, target = TRANSITIONS[sign]
        if self.outage not in sources:
            return False
        changes = target is not self.outage
        self.outage, self.why = target, why if target is not None else ''
        return changes

    def hear(self, report: Report, now: float) -> Heard:
        """Evaluates a report that passed `check_report`. Raises WrongReport.

        now -- time at which the report arrived
        """
        if self.master.is_absent and not self.master.is_back(report, now):
            return Heard()
        self.notice(Sign.LOCATED)
        was_nowhere = self._was_nowhere
        heard = self.master.hear(report)
        self._unready = report.said.unready
        self.liveness.hear(report, self.record.graph, now)
        if self.outage is Outage.SILENT:
            self.liveness.nothing_to_answer(now)
        self.notice(Sign.REPORT)
        if report.pose.edge and was_nowhere:
            self.notice(Sign.FOUND)
        if heard.is_located:
            self._located = now - max(report.age, 0.0)
        self.master.grow(now - self._located)
        if heard.news.took or heard.news.refused or self.master.order is None:
            self.liveness.nothing_to_answer(now)
            self.notice(Sign.ANSWER)
        self.passed += heard.passed
        self._judge(heard, report, now)
        if not self.works:
            self._timer.stop()
        driven = self._timer.follow(self.record, now)
        if driven is not None:
            self.driven.append(driven)
        return heard

    @property
    def is_at_rest(self) -> bool:
        """Whether the robot stands, and no order that lets it drive is on its way."""
        protocol = self.master.protocol
        return (self.master.order is None and not protocol.may_drive
                and not protocol.is_anywhere and self.liveness.stands)

    def _judge(self, heard: Heard, report: Report, now: float) -> None:
        if heard.passed:
            self._refusals = 0
        if heard.news.refused:
            self._follow_refusal(heard)
        elif heard.news.took and report.motion is Motion.ON_ROUTE:
            self.notice(Sign.DRIVES)
        if report.said.unready is ReasonCode.EMERGENCY_STOP:
            self.notice(Sign.EMERGENCY, 'emergency stop')
        if not self.is_halted:
            self._judge_motion(heard, report)
        if self.master.clock_is_off:
            self.notice(Sign.CLOCK_OFF, 'its clock is ahead of the fleet computer\'s: correct the '
                                        'time of both (NTP)')
        elif self.liveness.seen - self._retried > RETRY:
            self.notice(Sign.CLOCK_RIGHT)

    def _judge_motion(self, heard: Heard, report: Report) -> None:
        if heard.cause is not None:
            sign = sign_of_epoch(heard.cause, heard.had_route)
            if sign is not None:
                reason = report.said.reason
                self.notice(sign, reason.text if reason else words_of(heard.cause))
        elif heard.news.failed and self.outage is None:
            self.notice(sign_of(heard.news.failed), heard.news.failed.text)
        elif heard.is_off_graph and self.record.is_standing:
            self.notice(Sign.LEFT_GRAPH, 'it reports that it is off the graph')
        elif heard.left and (self.outage is None or self.outage is Outage.STOPPED
                             and not heard.is_near):
            self.notice(Sign.TAKEN, f'it was moved without a route: {heard.expected}')

    def _follow_refusal(self, heard: Heard) -> None:
        self._has_refused = True
        sign = sign_of(heard.news.refused)
        if sign in (Sign.CLOCK_OFF, Sign.LINK_LOST, Sign.EMERGENCY):
            self._retried = self.liveness.seen
            self.notice(sign, heard.news.refused.text)
            return
        self._refusals += not heard.news.was_shorter
        if self._refusals >= REFUSALS:
            self.notice(Sign.FAILURE,
                        f'it refused its route {REFUSALS} times: {heard.news.refused}')

    @property
    def _was_nowhere(self) -> bool:
        """Whether the robot was never on the graph."""
        return self.record.position is None and not self.record.held

    # -- time -------------------------------------------------------------------------------------

    def tick(self, now: float, heard: float) -> None:
        """Detects a silent or deaf robot, and allows for the growing age of its last location.

        heard -- time until which all arrived reports were evaluated
        """
        if self.master.order is None:
            self.liveness.nothing_to_answer(now)
        if self.liveness.is_silent(heard):
            self.notice(Sign.SILENCE, f'it has not reported for {SILENCE:.0f} s')
        elif self.outage is None and self.liveness.is_deaf(heard):
            self.notice(Sign.NO_ANSWER, f'it reports, but has not answered an order for '
                        f'{ANSWER:.0f} s: do its message definitions differ, or was the clock of '
                        'the fleet computer set back?')
        if self.liveness.is_seen:
            self.master.grow(heard - self._located)

    def return_to_work(self, now: float) -> bool:
        """Lets a standing robot work again after a fleet stop, an emergency stop or a lost link.

        Returns whether this changed anything.
        """
        if self.works or self.outage not in (None, Outage.STOPPED, Outage.LOST_LINK) or (
                not self.is_at_rest):
            return False
        before = self.is_halted, self.outage
        self.is_halted = False
        if self._unready not in (ReasonCode.EMERGENCY_STOP, ReasonCode.LOST_LINK):
            self.notice(Sign.STANDS)
            self.notice(Sign.LINK_BACK)
        return before != (self.is_halted, self.outage)

    def other_beginning(self) -> Optional[GraphPosition]:
        """Returns another starting place to be tried after a refusal; None: there is none.

        Each robot decides by itself how near to a vertex it must be to stand on the vertex. If the
        robot refused a route that begins on an edge, the vertex near the robot is tried. If it
        refused a route that begins at a vertex, the edge is tried.
        """
        record, master = self.record, self.master
        if not self._has_refused or not master.is_ready:
            return None
        self._has_refused = False
        if not self.works or not record.is_standing or record.position is None:
            return None
        vertex = position_of(record.pose, record.graph, NEAR)
        if vertex is None or vertex.vertex is None or record.pose.fraction in (0.0, 1.0) or (
                is_dock(vertex, record.graph)):
            return None
        return vertex if record.position.vertex is None else GraphPosition(
            edge=record.pose.edge, fraction=record.pose.fraction)

    def become(self, kind: RobotType) -> None:
        """Notes that the robot has another type now, because of its load."""
        self.type = kind
        self.master.become(kind)

    # -- commands of people -----------------------------------------------------------------------

    def not_back_yet(self, now: float) -> str:
        """Returns why a person cannot put the robot back into service now.

        Empty: a person can, or the robot works already.
        """
        if self.works:
            return ''
        if self.outage is Outage.ABSENT:
            return f'{self.name} was declared absent: switch it on, and it is back'
        if now - self.liveness.seen > SILENCE or self.outage is Outage.DEAF:
            return f'{self.name} does not report or answer: repair its link first'
        if not self.is_at_rest:
            return (f'{self.name} does not stand still yet, or has a route to drive, or its '
                    'locations are old: try again in a moment')
        return ''

    def come_back(self) -> str:
        """Puts the robot back into service where it is, because a person says that it can work.

        Returns why this is impossible; empty: done.
        """
        position = self.master.position_at(self.record.pose)
        if position is None:
            return f'{self.name} is off the graph: bring it onto an edge'
        beside = self.master.beside(position)
        if beside > BESIDE:  # its next reports would contradict this position
            return (f'{self.name} is {beside:.2f} m beside the graph '
                    f'({position.told(self.record.graph)}): bring it onto an edge')
        self.master.settle(position)
        self.notice(Sign.BROUGHT_IN)
        self.is_halted = False
        self._refusals = 0
        return ''

    def declare_absent(self, now: float) -> str:
        """Declares on behalf of a person that the robot is not on the site.

        Returns why this is refused; empty: done.
        """
        if self.liveness.is_seen and now - self.liveness.seen <= SILENCE:
            return f'{self.name} reports: switch it off first'
        self.master.declare_absent(now)
        self.notice(Sign.DECLARED_ABSENT, 'it was declared absent')
        self.is_halted = self.comes_to_rest = False
        self.dock, self.tops_up, self.charge_until = None, False, 0.0
        self.liveness = Liveness()
        return ''

    @property
    def knowledge(self) -> Knowledge:
        """What is known of the robot's place."""
        return self.master.allocation.knowledge
