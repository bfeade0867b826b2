"""The fleet manager's mind: missions and reports in, routes and statuses out.

Neither ROS nor a planner nor a clock: every event comes with the time at which it happened (s,
monotonic), and every answer is a list of actions. What must outlive a restart is on the disk before
the answer is given; where the disk cannot be written, only stops and cuts are.
"""
from __future__ import annotations

from typing import Dict, Iterable, List, Mapping, Tuple

from graph_fleet_manager.fleet import Fleet
from graph_fleet_manager.planning.road_network import RoadNetwork
from graph_fleet_manager.planning.tasks import Outcome
from graph_fleet_manager.supervision import mission_commands, mission_progress
from graph_fleet_manager.supervision.actions import Action, TellStatus
from graph_fleet_manager.supervision.charging import ChargeQueue
from graph_fleet_manager.supervision.errands import Errand, errand_of
from graph_fleet_manager.supervision.fleet_stop import FleetStop
from graph_fleet_manager.supervision.journal import Journal, JournalUnavailable
from graph_fleet_manager.supervision.liveness import SILENCE
from graph_fleet_manager.supervision.missions import (
    Acceptance,
    Command,
    MissionBook,
    MissionState,
    Request,
    RequestRefused,
)
from graph_fleet_manager.supervision.networks import Networks
from graph_fleet_manager.supervision.outage_watch import OutageWatch
from graph_fleet_manager.supervision.outages import Outage
from graph_fleet_manager.supervision.outbox import Outbox
from graph_fleet_manager.supervision.plan_executor import PlanExecutor
from graph_fleet_manager.supervision.reports import (
    Report,
    WrongReport,
    check_report,
    old_location,
)
from graph_fleet_manager.supervision.restoring import robots_of
from graph_fleet_manager.supervision.settings import RobotSettings
from graph_fleet_manager.supervision.waiting_missions import WaitingMissions
from trajectory_graph import Graph
from trajectory_graph.route_protocol import RouteRefusal


class Supervisor:
    """All robots and missions of one fleet.

    settings -- of robots by name; those that are missing are as RobotSettings has them
    rate     -- simulated robots are so many times faster than the clock
    """

    def __init__(self, graph: Graph, fleet: Fleet, settings: Mapping[str, RobotSettings],
                 journal: Journal, now: float, rate: float = 1.0) -> None:
        self.robots = robots_of(fleet, settings, graph, journal.robots())
        self.networks = Networks(graph, fleet, rate)
        self.charging = ChargeQueue(self.robots)
        self.book = MissionBook(journal.missions(), journal.last_serial() + 1)
        self._journal = journal
        self._began = now
        self._is_starting = True
        self._waiting = WaitingMissions(self.book, self.robots)
        self._out = Outbox(journal, self.book, self.robots)
        self.plan_executor = PlanExecutor(self.robots, self._out)
        self._stop = FleetStop(journal, self.robots, self._out)
        self._outages = OutageWatch(self.book, self.robots, self._out, self.plan_executor)
        for mission, why in mission_progress.no_longer_possible(self.book, self.acceptance):
            self.book.set(mission, MissionState.FAILED, why)

    @property
    def network(self) -> RoadNetwork:
        """The graph without what is closed, by learned times."""
        return self.networks.network

    @property
    def trouble(self) -> str:
        """Why nothing can be stored, a clause; empty: it can.

        While it lasts no mission is accepted and no robot gets anything new to drive.
        """
        return self._out.trouble

    @property
    def is_stopped(self) -> bool:
        """Is every robot to stand until the fleet is resumed?"""
        return self._stop.is_in_force

    @property
    def acceptance(self) -> Acceptance:
        """What requests are judged by."""
        return Acceptance(self.network.graph, {r.name: r.type for r in self.robots.values()})

    # -- missions ---------------------------------------------------------------------------------

    def request(self, request: Request, now: float) -> List[Action]:
        """Accepts, refuses or repeats; an accepted mission is on the disk before it is told."""
        known = self.book.find(request.id)
        try:
            if known is None or known.request != request:
                ended = self._journal.find(request) if request.stamp else None
                if ended is not None:  # latched, or under way for long
                    self._out.put(TellStatus(ended.status))
                    return self._out.take(now)
            mission = self.book.add(request, self.acceptance)
        except RequestRefused as refusal:
            return self._refuse(request, str(refusal), now)
        except JournalUnavailable as unavailable:
            return self._refuse(request, unavailable.reason, now)
        actions = self._out.take(now)
        if mission is not None and self.trouble:
            self.book.withdraw(mission, known)
            return [*actions, *self._refuse(request, self.trouble, now)]
        if mission is None and known is not None and known.serial not in self.book.changed:
            self._out.put(TellStatus(known.status))
        self._go_on(now)
        return [*actions, *self._out.take(now)]

    def _refuse(self, request: Request, reason: str, now: float) -> List[Action]:
        self._out.put(TellStatus(mission_commands.refused(request, reason)))
        return self._out.take(now)

    def command(self, request_id: int, command: Command, now: float) -> List[Action]:
        """Cancels, pauses, resumes, or ends a dwell."""
        mission = self.book.find(request_id)
        if mission is None or not mission.state.is_open:
            self._out.note(f'There is no open mission {request_id} for {command.name}.', True)
            return self._out.take(now)
        before = mission.stored or mission.status
        if self.trouble and command in (Command.RESUME, Command.RELEASE):
            self._out.put(TellStatus(mission_commands.not_done(before, command, self.trouble)))
            return self._out.take(now)
        problem = mission_commands.carry_out(command, mission, self.book, self.plan_executor)
        if problem:
            self._out.note(problem)
        self.plan_executor.replan()
        self._go_on(now)
        actions = self._out.take(now)
        if self.trouble:
            told = mission_commands.not_stored(before, command, self.trouble)
            actions.append(TellStatus(told))
        return actions

    # -- robots -----------------------------------------------------------------------------------

    def report(self, name: str, report: Report, now: float) -> List[Action]:
        """A robot tells where it is and how far its route is."""
        robot = self.robots[name]
        try:
            check_report(report, self.network.graph)
        except WrongReport as wrong:
            self._out.note_state(name, f'A report of {name} is ignored: {wrong}.', '')
            return self._out.take(now)
        self._out.note_state(name, '', f'The reports of {name} make sense again.')
        self._out.note_state(f'{name}/age', old_location(name, report),
                             f'The locations of {name} are new again.')
        before, begun = robot.progress, robot.record.begun
        was_seen = robot.liveness.is_seen
        if self._is_starting and not was_seen:
            self._stop.look_for(robot, report)
        robot.hear(report, now)
        robot.begin_elsewhere()
        if robot.record.begun != begun or was_seen != robot.liveness.is_seen:
            self.plan_executor.forget_plan_of(name)
        if robot.client.to_order_anew:
            robot.client.try_again(self._out.new_id, robot.client.to_order_anew)
        if robot.drives_on(report):
            robot.client.halt(self._out.new_id)
            self._out.send()
        self.networks.learn(robot, now)
        if before != robot.progress:
            self._out.robot_changed(name)
            if mission_progress.follow(self.book, robot, now):
                self._go_on(now)
        self._outages.look()
        return self._out.take(now)

    def refusal(self, name: str, refusal: RouteRefusal, now: float,
                stamp: float = 0.0) -> List[Action]:
        """A robot did not take up an order; `stamp`: s, when, by its clock, 0: unknown."""
        robot = self.robots[name]
        was_stopped = robot.outage is Outage.STOPPED
        if not robot.hear_refusal(refusal, stamp):
            return self._out.take(now)
        self._out.robot_changed(name)
        if not (was_stopped and robot.outage is Outage.STOPPED):  # each trial is refused then
            self._out.note(f'{name} refused route {refusal.route_id}: {refusal.reason}.', True)
        self._outages.look()
        return self._out.take(now)

    def battery(self, name: str, charge: float, now: float) -> List[Action]:
        """A robot's state of charge, 0..1."""
        self.robots[name].battery.tell(charge, now)
        return self._out.take(now)

    def take_out(self, name: str, now: float) -> List[Action]:
        """Takes a robot out of service: it stops where it is."""
        robot = self.robots[name]
        robot.client.halt(self._out.new_id)
        robot.fail(Outage.OUT_OF_SERVICE, 'it was taken out of service')
        self._out.robot_changed(name)
        self._outages.look()
        self._go_on(now)
        return self._out.take(now)

    def bring_in(self, name: str, now: float) -> Tuple[str, List[Action]]:
        """Puts a robot back into service where it is; also tells why not, or nothing."""
        robot = self.robots[name]
        if self.is_stopped:
            return 'the fleet is stopped: resume it first', self._out.take(now)
        problem = robot.not_back_yet(now)
        if problem or (robot.outage is None and not robot.is_halted):
            return problem, self._out.take(now)
        problem = robot.come_back(robot.place_at(robot.record.pose))
        self.plan_executor.forget_plan_of(name)
        self._outages.look()
        self._go_on(now)
        return problem, self._out.take(now)

    def stop_fleet(self, now: float) -> List[Action]:
        """Every robot gets an empty route at once, planner or not."""
        self._stop.stop()
        return self._out.take(now)

    def resume_fleet(self, now: float) -> Tuple[List[str], List[Action]]:
        """Every robot goes on from where it is; also names those for which a person must look.

        One that has not obeyed the stop yet goes on once it has.
        """
        self._stop.end()
        self._go_on(now)
        problems = [f'{robot.name}: {robot.why}' for robot in self.robots.values()
                    if robot.outage is not None and robot.outage.needs_person]
        actions = self._out.take(now)
        if self.trouble:
            problems.insert(0, f'robots go on only once that is stored: {self.trouble}')
        return problems, actions

    # -- the graph and the plan -------------------------------------------------------------------

    def close_edges(self, edges: Iterable[int], now: float) -> List[Action]:
        """Edges not to be used from now on; what is released already is driven to its end."""
        if self.networks.close(edges):
            self.plan_executor.replan()
            self._go_on(now)
        return self._out.take(now)

    def plan_made(self, number: int, outcome: Outcome, now: float) -> List[Action]:
        """The planner's answer; one that does not fit what is released by now is left out."""
        if self.plan_executor.plan_made(number, outcome):
            self._go_on(now)
        return self._out.take(now)

    def plan_failed(self, number: int, reason: str, now: float) -> List[Action]:
        """The planner could not answer; the plan in force stays."""
        self.plan_executor.plan_failed(number, reason)
        return self._out.take(now)

    # -- what goes on -----------------------------------------------------------------------------

    def tick(self, now: float) -> List[Action]:
        """Looks at the clock; to be called ten to twenty times a second."""
        self._go_on(now)
        return self._out.take(now)

    def errands(self) -> Dict[str, Errand]:
        """What every robot is about."""
        missions = {m.robot: m for m in self.book.open if m.robot}
        return {name: errand_of(missions.get(name), robot.dock)
                for name, robot in self.robots.items()}

    def _go_on(self, now: float) -> None:
        for robot in self.robots.values():
            robot.look(now)
            mission_progress.follow(self.book, robot, now)
            if not self.trouble and robot.try_after_stop(now, self._out.new_id,
                                                         self.network.graph):
                self._out.robot_changed(robot.name)
            if not self.is_stopped and robot.go_on_after_stop(now):
                self.plan_executor.forget_plan_of(robot.name)
        self._outages.look()
        self._out.send()
        if self._is_starting:
            self._is_starting = (not all(r.liveness.is_seen for r in self.robots.values())
                                 and now - self._began < SILENCE)
        if self.is_stopped:
            self._waiting.hold('the fleet is stopped')
        elif self._is_starting or self.trouble:
            self.plan_executor.shorten()
        if self._is_starting or self.is_stopped or self.trouble:
            return
        self.plan_executor.give_up_waiting(now)
        busy = {m.robot for m in self.book.open if m.robot}
        for name in self.charging.update(busy, self._waiting.short, self.network, now):
            self._out.robot_changed(name)
            self.plan_executor.replan()
        for name in self._waiting.assign(self.acceptance, self.networks, now):
            self.plan_executor.begin_mission(name)
            mission_progress.follow(self.book, self.robots[name], now)
        self.plan_executor.go_on(self.errands(), self.network, now)
