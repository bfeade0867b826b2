"""The fleet manager's mind: missions and reports in, routes and statuses out.

Neither ROS nor a planner nor a clock: every event comes with the time at which it happened (s,
monotonic), and every answer is a list of actions. What must outlive a restart is on the disk before
the answer is given.
"""
from __future__ import annotations

from math import inf
from typing import Dict, Iterable, List, Mapping, Optional, Set, Tuple

from graph_fleet_manager.fleet import Fleet
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.tasks import Outcome
from graph_fleet_manager.supervision import mission_progress
from graph_fleet_manager.supervision.actions import (
    Action,
    AskPlanner,
    Note,
    SendRoute,
    TellStatus,
)
from graph_fleet_manager.supervision.assignment import assign
from graph_fleet_manager.supervision.charging import ChargeQueue
from graph_fleet_manager.supervision.errands import (
    Duty,
    Errand,
    Snapshot,
    errand_of,
    goes_until,
    snapshot,
)
from graph_fleet_manager.supervision.journal import Journal, RobotMemory
from graph_fleet_manager.supervision.missions import (
    Acceptance,
    Command,
    MissionBook,
    MissionState,
    Request,
    RequestRefused,
    Status,
)
from graph_fleet_manager.supervision.outages import Outage
from graph_fleet_manager.supervision.plan_in_force import PlanInForce
from graph_fleet_manager.supervision.release import released
from graph_fleet_manager.supervision.reports import (
    Report,
    WrongReport,
    check_report,
)
from graph_fleet_manager.supervision.robots import SILENCE, ManagedRobot, RobotSettings
from graph_fleet_manager.supervision.route_client import RouteClient
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteRefusal

PLANNER_PATIENCE = 10.0  # s after which an answer of the planner is no longer waited for
AGAIN = 2.0              # s between two plans while somebody has none that serves it
ASSIGN_AGAIN = 1.0       # s after which waiting missions are looked at although nobody came free
_STOPPED = 'fleet_is_stopped'


class Supervisor:
    """All robots and missions of one fleet.

    settings -- of robots by name; those that are missing are as RobotSettings has them
    """

    def __init__(self, graph: Graph, fleet: Fleet, settings: Mapping[str, RobotSettings],
                 journal: Journal, now: float) -> None:
        self.journal = journal
        self._fleet = fleet
        self.robots: Dict[str, ManagedRobot] = {}
        for robot in fleet.robots:
            own = settings.get(robot.name, RobotSettings())
            self.robots[robot.name] = ManagedRobot(
                robot.name, robot.type, own, RouteClient(graph, robot.type.speed, own.slack))
        self.network = RoadNetwork(graph, (), fleet.dock_approach)
        self.is_stopped = bool(journal.value(_STOPPED))
        self.charging = ChargeQueue()
        self.plan: Optional[PlanInForce] = None
        self.waits_for: Dict[str, str] = {}
        """What holds up each robot, in words; empty: nothing."""
        self.book = MissionBook(journal.missions(), journal.last_serial() + 1)
        self._began = now
        self._is_starting = True
        self._asked: Optional[Tuple[int, float, Snapshot]] = None
        self._number = 0
        self._replan = True
        self._failed = False
        self._planned = -inf
        self._assigned: Tuple[object, float] = ((), -inf)
        self._stale: Set[str] = set()   # robots whose memory is to be written
        self._shortening: Set[str] = set()
        self._renew: Set[str] = set()   # robots whose next edges are another mission's
        self._outages: Dict[str, Optional[Outage]] = {}
        self._out: List[Action] = []
        self._restore()

    def _restore(self) -> None:
        for name, memory in self.journal.robots().items():
            robot = self.robots.get(name)
            if robot is None or any(abs(edge) not in self.network.graph.edges
                                    for edge in memory.client.track):
                continue
            robot.client.restore(memory.client)
            if memory.outage is not None and memory.outage.needs_person:
                robot.outage, robot.why = memory.outage, memory.why
            robot.is_halted = memory.is_halted
            if memory.is_halted:
                robot.client.halt(self.journal.next_route_id)
        for mission in mission_progress.with_robot_gone(self.book, self.robots):
            self.book.set(mission, MissionState.FAILED, 'its robot is no longer in the fleet')

    @property
    def acceptance(self) -> Acceptance:
        """What requests are judged by."""
        return Acceptance(self.network.graph, {r.name: r.type for r in self.robots.values()})

    # -- missions ---------------------------------------------------------------------------------

    def request(self, request: Request, now: float) -> List[Action]:
        """Accepts, refuses or repeats; an accepted mission is on the disk before it is told."""
        try:
            mission = self.book.add(request, self.acceptance)
        except RequestRefused as refused:
            self._out.append(TellStatus(Status(request.id, MissionState.REFUSED,
                                               reason=str(refused))))
            return self._answer()
        if mission is None:
            known = self.book.find(request.id)
            if known is not None:
                self._out.append(TellStatus(known.status))
        self._go_on(now)
        return self._answer()

    def command(self, request_id: int, command: Command, now: float) -> List[Action]:
        """Cancels, pauses, resumes, or ends a dwell."""
        mission = self.book.find(request_id)
        if mission is None or not mission.state.is_open:
            self._note(f'There is no open mission {request_id} for {command.name}.', True)
            return self._answer()
        name = mission.robot
        if command is Command.CANCEL:
            self.book.set(mission, MissionState.CANCELLED, 'cancelled on request')
        elif command is Command.PAUSE:
            self.book.set(mission, MissionState.PAUSED)
        elif command is Command.RESUME and mission.state is MissionState.PAUSED:
            self.book.set(mission, MissionState.ACTIVE if name else MissionState.PENDING)
            self._shortening.discard(name)
        elif command is Command.RELEASE and mission.dwell_until is not None:
            self.book.reach(mission)
        if name and command in (Command.CANCEL, Command.PAUSE):
            self._shortening.add(name)
        self._replan = True
        self._go_on(now)
        return self._answer()

    def open_statuses(self) -> List[Status]:
        """The status of every open mission, for who comes late."""
        return [mission.status for mission in self.book.open]

    # -- robots -----------------------------------------------------------------------------------

    def report(self, name: str, report: Report, now: float) -> List[Action]:
        """A robot tells where it is and how far its route is."""
        robot = self.robots[name]
        try:
            check_report(report, self.network.graph)
        except WrongReport as wrong:
            self._note(f'A report of {name} is ignored: {wrong}.', True)
            return self._answer()
        before = robot.client.done, robot.client.end, robot.client.over
        robot.hear(report, now)
        if before != (robot.client.done, robot.client.end, robot.client.over):
            self._stale.add(name)
            if mission_progress.follow(self.book, robot, now):
                self._go_on(now)
        self._note_outages()
        return self._answer()

    def refusal(self, name: str, refusal: RouteRefusal, now: float) -> List[Action]:
        """A robot did not take up an order."""
        robot = self.robots[name]
        robot.hear_refusal(refusal)
        self._stale.add(name)
        self._note(f'{name} refused route {refusal.route_id}: {refusal.reason}.', True)
        self._note_outages()
        return self._answer()

    def battery(self, name: str, charge: float, now: float) -> List[Action]:
        """A robot's state of charge, 0..1."""
        self.robots[name].battery = charge
        return self._answer()

    def take_out(self, name: str, now: float) -> List[Action]:
        """Takes a robot out of service: it stops where it is."""
        robot = self.robots[name]
        robot.client.halt(self.journal.next_route_id)
        robot.fail(Outage.OUT_OF_SERVICE, 'it was taken out of service')
        self._stale.add(name)
        self._note_outages()
        self._go_on(now)
        return self._answer()

    def bring_in(self, name: str, now: float) -> Tuple[str, List[Action]]:
        """Puts a robot back into service where it is; also tells why not, or nothing."""
        robot = self.robots[name]
        if self.is_stopped:
            return 'the fleet is stopped: resume it first', self._answer()
        if robot.outage is None and not robot.is_halted:
            return '', self._answer()
        if now - robot.seen > SILENCE:
            return f'{name} does not report: mend its link first', self._answer()
        if robot.client.order is not None or not robot.is_still(now):
            return f'{name} does not stand still yet: try again in a moment', self._answer()
        problem = robot.come_back(robot.place_at(robot.client.pose))
        self._forget_plan_of(name)
        self._note_outages()
        self._go_on(now)
        return problem, self._answer()

    def stop_fleet(self, now: float) -> List[Action]:
        """Every robot gets an empty route at once, planner or not."""
        self.is_stopped = True
        self.journal.write_value(_STOPPED, 1)
        for name, robot in self.robots.items():
            robot.client.halt(self.journal.next_route_id)
            robot.is_halted = True
            self._stale.add(name)
        self._send(now)
        return self._answer()

    def resume_fleet(self, now: float) -> Tuple[List[str], List[Action]]:
        """Every robot goes on from where it is; also names those for which a person must look.

        One that has not obeyed the stop yet goes on once it has.
        """
        self.is_stopped = False
        self.journal.write_value(_STOPPED, 0)
        self._go_on(now)
        problems = [f'{robot.name}: {robot.why}' for robot in self.robots.values()
                    if robot.outage is not None and robot.outage.needs_person]
        return problems, self._answer()

    # -- the graph and the plan -------------------------------------------------------------------

    def close_edges(self, edges: Iterable[int], now: float) -> List[Action]:
        """Edges not to be used from now on; what is released already is driven to its end."""
        known = frozenset(abs(e) for e in edges) & frozenset(self.network.graph.edges)
        if known != self.network.closed:
            self.network = self.network.with_closed(known)
            self._replan = True
            self._go_on(now)
        return self._answer()

    def plan_made(self, number: int, outcome: Outcome, now: float) -> List[Action]:
        """The planner's answer; one that does not fit what is released by now is left out."""
        if self._asked is None or self._asked[0] != number:
            return self._answer()
        _, asked_at, question = self._asked
        self._asked = None
        if question.fits(self.robots):
            self.plan = question.plan(outcome, asked_at)
        else:
            self._replan = True
        self._go_on(now)
        return self._answer()

    def plan_failed(self, number: int, reason: str, now: float) -> List[Action]:
        """The planner could not answer; the plan in force stays."""
        if self._asked is not None and self._asked[0] == number:
            self._asked = None
            self._failed = True
            self._note(f'The planner gave no plan: {reason}.', True)
        return self._answer()

    # -- what goes on -----------------------------------------------------------------------------

    def tick(self, now: float) -> List[Action]:
        """Looks at the clock; to be called ten to twenty times a second."""
        self._go_on(now)
        return self._answer()

    def errands(self) -> Dict[str, Errand]:
        """What every robot is about."""
        missions = {m.robot: m for m in self.book.open if m.robot}
        return {name: errand_of(missions.get(name), self.charging.granted.get(name))
                for name in self.robots}

    def _go_on(self, now: float) -> None:
        for robot in self.robots.values():
            robot.look(now)
            mission_progress.follow(self.book, robot, now)
            if robot.try_after_stop(now, self.journal.next_route_id, self.network.graph):
                self._stale.add(robot.name)
            if not self.is_stopped and robot.go_on_after_stop(now):
                self._forget_plan_of(robot.name)
        self._note_outages()
        self._send(now)
        if self._is_starting:
            self._is_starting = (not all(r.is_seen for r in self.robots.values())
                                 and now - self._began < SILENCE)
        if self._is_starting or self.is_stopped:
            return
        if self._asked is not None and now - self._asked[1] > PLANNER_PATIENCE:
            self._note('The planner does not answer; it is asked again.', True)
            self._asked = None
            self._replan = True
        busy = {m.robot for m in self.book.open if m.robot}
        if self.charging.update(self.robots, busy, self.network):
            self._replan = True
        self._assign(now)
        self._shorten()
        if self._asked is None:
            self._release()
            self._ask(now)
        self._send(now)

    def _assign(self, now: float) -> None:
        pending = [m for m in self.book.open if m.state is MissionState.PENDING]
        if not pending:
            return
        busy = {m.robot for m in self.book.open if m.robot}
        free = {name: robot for name, robot in self.robots.items()
                if robot.works and name not in busy and self.charging.may_work(robot)
                and (robot.client.held or robot.client.place is not None)}
        question = (tuple(m.serial for m in pending), tuple(free))
        if question == self._assigned[0] and now - self._assigned[1] < ASSIGN_AGAIN:
            return
        self._assigned = question, now
        found = assign(pending, free, self.robots, self.acceptance, self.network)
        for mission, name in found.assigned:
            self.book.set(mission, MissionState.ACTIVE, '', name)
            self._shortening.discard(name)
            self._renew.add(name)
            self._replan = True
            mission_progress.follow(self.book, self.robots[name], now)
        for mission in pending:
            if mission.serial in found.waiting:
                self.book.set(mission, MissionState.PENDING, found.waiting[mission.serial])

    def _shorten(self) -> None:
        """Robots whose mission was cancelled or paused come to rest as soon as they can."""
        for name in list(self._shortening):
            robot = self.robots[name]
            if not robot.works or not robot.client.shorten(self.journal.next_route_id):
                self._shortening.discard(name)
                self._replan = True
            self._stale.add(name)

    def _release(self) -> None:
        """Gives every robot the edges that it may have now."""
        plan = self.plan
        if plan is None:
            return
        errands = self.errands()
        clients = {name: robot.client for name, robot in self.robots.items()}
        movers = [name for name, errand in errands.items()
                  if errand.duty in (Duty.MISSION, Duty.CHARGE) and name not in plan.unserved]
        asked = plan.asked_to_move(movers, {name: c.end for name, c in clients.items()})
        for name, own in plan.plans.items():
            robot = self.robots[name]
            self.waits_for[name] = ''
            if not robot.works or name in self._shortening or not robot.client.is_ready:
                continue
            until = goes_until(robot, errands[name], own, name in asked)
            given = released(name, plan, clients, until, robot.settings.release_ahead,
                             self.network.closed)
            self.waits_for[name] = given.waits_for
            if given.edges:
                robot.client.extend(given.edges, self.journal.next_route_id, name in self._renew)
                self._renew.discard(name)
                self._stale.add(name)

    def _ask(self, now: float) -> None:
        """Asks for another plan where this one does not serve what is to be done now."""
        again = self._failed or bool(self.plan and self.plan.unserved)
        if not self._replan and not (again and now - self._planned >= AGAIN):
            return
        question = snapshot(self.robots, self.errands(), self.plan, now)
        self._replan = self._failed = False
        self._planned = now
        if not question.tasks:
            return
        self._number += 1
        self._asked = (self._number, now, question)
        self._out.append(AskPlanner(self._number, question.tasks, question.obstacles,
                                    self.network.closed))

    def _send(self, now: float) -> None:
        for name, robot in self.robots.items():
            sending = robot.client.due(now)
            if sending is not None:
                self._out.append(SendRoute(name, *sending))

    # -- what changed -----------------------------------------------------------------------------

    def _forget_plan_of(self, name: str) -> None:
        if self.plan is not None:
            self.plan.drop(name)
        self._stale.add(name)
        self._replan = True

    def _note_outages(self) -> None:
        """Draws the consequences where a robot dropped out or came back."""
        for name, robot in self.robots.items():
            if name in self._outages and self._outages[name] is robot.outage:
                continue
            before = self._outages.get(name)
            self._outages[name] = robot.outage
            self._stale.add(name)
            self._replan = True
            if robot.outage is not None:
                mission_progress.drop_out(self.book, robot)
                if robot.outage is not Outage.UNSEEN:
                    self._note(f'{name} cannot work: {robot.why or robot.outage.value}.', True)
            else:
                mission = self.book.of_robot(name)
                if mission is not None:
                    self.book.set(mission, mission.state)
                if before is not None:
                    self._note(f'{name} works again.')

    def _note(self, text: str, is_warning: bool = False) -> None:
        self._out.append(Note(text, is_warning))

    def _answer(self) -> List[Action]:
        """Everything to be done, once all that it relies on is on the disk."""
        for mission in self.book.take_changes():
            self.journal.write_mission(mission)
            self._out.append(TellStatus(mission.status))
        for name in sorted(self._stale):
            robot = self.robots[name]
            self.journal.write_robot(name, RobotMemory(robot.client.memory, robot.outage, robot.why,
                                                       robot.is_halted))
        self._stale.clear()
        self.journal.commit()
        out, self._out = self._out, []
        return out
