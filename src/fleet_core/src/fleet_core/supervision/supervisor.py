"""The supervisor: takes missions and reports, and returns routes and statuses.

It uses neither ROS nor a planner. Each event comes with its time (s, monotonic), and each answer is
a list of actions. The supervisor reads a clock only after a commit, because a commit may take long.
The state that must survive a restart is on the disk before the answer is returned. While the disk
cannot be written, only stops and shorter routes are returned.
"""
from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from math import isnan
from typing import Callable, Dict, Iterable, List, Mapping, Optional, Sequence, Set, Tuple, Union

from fleet_core.fleet import Fleet
from fleet_core.interlocking.changes import Changes
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.conformance import Conformance
from fleet_core.interlocking.interlocking import InterlockedRobot, Interlocking
from fleet_core.interlocking.reports import (
    Report,
    check_report,
    old_location,
)
from fleet_core.interlocking.resources import Needs, Resource
from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision import mission_commands, mission_progress
from fleet_core.supervision.actions import Action, PublishStatus
from fleet_core.supervision.assumptions import World, WorldView
from fleet_core.supervision.charging import ChargerDesk, docks_of
from fleet_core.supervision.device_desk import FRESH, DeviceDesk
from fleet_core.supervision.duties import NO_LIMIT, Errand, errand_of
from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.journal import Journal
from fleet_core.supervision.journal_database import JournalUnavailable
from fleet_core.supervision.laden_types import LadenTypes
from fleet_core.supervision.liveness import SILENCE
from fleet_core.supervision.load_room import LoadRoom
from fleet_core.supervision.machine_view import MachineReports
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.mission_times import MissionTimes
from fleet_core.supervision.missions import (
    Acceptance,
    CommandKind,
    Mission,
    MissionChange,
    MissionState,
    Request,
    RequestRefused,
    Status,
    StepAnswer,
)
from fleet_core.supervision.networks import Networks
from fleet_core.supervision.outage_watch import OutageWatch
from fleet_core.supervision.outages import Outage, Sign
from fleet_core.supervision.outbox import DEVICE_REQUEST, Outbox
from fleet_core.supervision.plan_executor import PlanExecutor
from fleet_core.supervision.restoring import (
    RemovedRobot,
    removed_of,
    robots_of,
)
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.run_number import RUN_NUMBER, RunNumber
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.site_resources import chargers_of, resources_of
from fleet_core.supervision.station_desk import StationDesk
from fleet_core.supervision.station_room import StationRoom
from fleet_core.supervision.switching import OrderSwitching
from fleet_core.supervision.time_to_go import time_over, time_to_go
from fleet_core.supervision.timetable_runs import TimetableRuns, stored_name
from fleet_core.supervision.waiting_missions import WaitingMissions
from fleet_core.supervision.waits import FLEET_STOPPED, NO_WAIT, STARTING, Wait, WaitCode
from fleet_core.supervision.work_desk import NEWEST_STEP, WorkDesk
from fleet_core.supervision.work_requests import WorkRequests
from fleet_core.work.site_work import SiteWork
from fleet_core.work.timetables import shown_at
from route_protocol.devices import DeviceReport
from route_protocol.messages import WrongReport
from route_protocol.steps import StepReport
from route_protocol.values import EpochCause
from trajectory_graph import Graph
from trajectory_graph.id_lists import listed


class Supervisor:
    """All robots and missions of one fleet.

    Each public method handles one event (a request, a report, a command, a tick) and returns the
    actions to be carried out. It passes the event to the module that is in charge:

    - `book` keeps the missions, and `charging` says which robots go to chargers.
    - `desk` leads missions with steps, and keeps the loads of robots.
    - `stations` says which robots may go to stations, and where the others wait.
    - `plan_executor` asks the planner, and requests grants in the order of the plan.
    - `interlocking` grants edges, and decides which orders may be sent.
    - `devices` keeps the reports of doors and other devices.

    settings -- of robots by name; a robot without an entry gets the defaults of RobotSettings
    rate     -- the factor by which simulated robots are faster than the clock
    switching -- looks for a better order while robots are late; None: the order stays
    conformance -- checks each event against the model of allocations; None: events are not checked
    resources   -- zones and other resources, in addition to the devices, stations and chargers of
                   `work` and `fleet`
    work        -- the content of the site's work file; None: the site has none
    clock       -- returns the present time (s) of the clock that gives events their times
    """

    def __init__(self, graph: Graph, fleet: Fleet, settings: Mapping[str, RobotSettings],
                 journal: Journal, now: float, rate: float = 1.0,
                 gate: Optional[StopGate] = None,
                 switching: Optional[OrderSwitching] = None,
                 conformance: Optional[Conformance] = None,
                 resources: Sequence[Resource] = (),
                 work: Optional[SiteWork] = None,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self.gate = gate or StopGate()
        work = work or SiteWork()
        chargers = chargers_of(work, fleet, graph)
        resources = (*resources_of(work, chargers.values()), *resources)
        laden = LadenTypes(work.loads, fleet.all_types)
        self.networks = Networks(graph, fleet, rate, resources, laden.types)
        self.rate = rate
        """The factor by which robots are faster than the clock."""
        memories, stored = journal.robots(), journal.graph()
        is_same = graph.is_same(stored)
        before = None if is_same else stored
        changes = Changes()
        self.robots = robots_of(fleet, settings, graph, memories, before, now,
                                journal.milliseconds, changes)
        self.removed: Dict[str, RemovedRobot] = removed_of(fleet, graph, memories, before, now,
                                                           journal.milliseconds, changes)
        """Robots that are not in the fleet file any more, but may be on the site."""
        self.acceptance = Acceptance(graph, {r.name: r.type for r in self.robots.values()})
        """The data with which requests are checked."""
        self.book = MissionBook(
            journal.missions(), journal.last_serial() + 1,
            {serial: now - seconds for serial, seconds in journal.stays().items()})
        self._journal = journal
        self._began = self._heard = now
        self._is_starting = True
        # (robot, resource): the robot is at a place that needs a device, which does not report open
        self._lost: Set[Tuple[str, str]] = set()
        # after the loss of the journal: nothing is granted until all robots stand
        self._is_recovering = False
        self.desk = WorkDesk(self.book, self.robots, journal.works(), journal.loads(),
                             journal.value(NEWEST_STEP), journal.milliseconds,
                             MachineReports(work.step_devices))
        self.load_room = LoadRoom(laden, self.robots, self.desk, self.networks.geometry,
                                  fleet.clearance)
        self.desk.lacks_room = self.load_room.lacks_room
        self._work_requests = WorkRequests(work, graph, self.book)
        self.times = MissionTimes(self.book, journal.milliseconds)
        self.timetables = TimetableRuns(work.timetables, journal.value, journal.milliseconds)
        self._waiting = WaitingMissions(self.book, self.robots, lambda: self.desk.laden)
        self._everywhere: Dict[str, InterlockedRobot] = {**self.robots, **self.removed}
        self._claims = Claims(Needs(resources, self.networks.geometry), journal.claims(),
                              journal.value(DEVICE_REQUEST), journal.milliseconds)
        self.interlocking = Interlocking(self.networks.geometry, fleet.clearance,
                                         self._everywhere, conformance, changes.follow(),
                                         self._claims)
        self.stations = StationDesk(work.stations, self._claims, self.book, self.robots,
                                    self.desk)
        self.desk.may_enter = self.stations.may_go_to
        self.devices = DeviceDesk(self._claims, lambda: self.interlocking.unknown_robots)
        self.charging = ChargerDesk(chargers, self._claims, self.book, self.robots,
                                    self.devices.view)
        self._out = Outbox(journal, self.book, self.robots, self._everywhere, self.interlocking,
                           self.desk, self.devices, clock)
        self._view = WorldView(self.robots, changes)
        self.plan_executor = PlanExecutor(self.robots, self.interlocking, self._out,
                                          switching, rate,
                                          self.stations.reserved | self.charging.reserved,
                                          laden.types)
        self.interlocking.stored(self._everywhere)
        self._declared_absent = {robot.name for robot in fleet.robots if robot.absent}
        self._run = RunNumber(journal)
        if self._run.is_wrong:
            self._doubt_journal('it is not the one that the last run has left')
        else:
            journal.store(values={RUN_NUMBER: self._run.draw()})
        self._outages = OutageWatch(self.book, self.robots, self._out, self.desk)
        self.stop = journal.stop()
        if self.stop.is_in_force:
            self._close_gate()
            self._halt(robot for robot in self.robots.values() if not robot.is_halted)
        if not is_same:
            self._keep_graph(graph)
        for mission, why in mission_progress.no_longer_possible(self.book, self.acceptance):
            if not self.desk.fail(mission, why):
                self.book.set(mission, MissionState.FAILED, why)

    @property
    def network(self) -> RoadNetwork:
        """The graph without closed edges, with learned times."""
        return self.networks.network

    @property
    def trouble(self) -> str:
        """Why nothing can be stored, as a clause; empty: everything can be stored.

        While nothing can be stored, no mission is accepted, and no robot gets anything new to
        drive.
        """
        return self._out.trouble

    @property
    def tick_due(self) -> Optional[float]:
        """The time at which the next `tick` is due at the latest; None: it comes as usual.

        This tick stores all changes that reports made, with their effects, in one commit.
        """
        return self._out.due

    @property
    def is_stopped(self) -> bool:
        """Whether each robot must stand until the fleet is resumed."""
        return self.interlocking.is_stopped

    @property
    def all_wait(self) -> Wait:
        """Why no robot gets a mission or anything new to drive."""
        if self.is_stopped:
            return FLEET_STOPPED
        if self.trouble:
            return Wait(WaitCode.DISK, f'the disk: {self.trouble}')
        return STARTING if self._is_starting or self._is_recovering else NO_WAIT

    @property
    def own_hindrances(self) -> Dict[str, Hindrance]:
        """What hinders each robot from serving any mission now, by the robot's name."""
        return self._waiting.own_hindrances

    def room(self) -> StationRoom:
        """Returns the stations and chargers to which a further robot may be sent now."""
        return self.stations.room(self.charging.at, self.charging.occupancies())

    # -- missions ---------------------------------------------------------------------------------

    def request(self, request: Request, now: float) -> List[Action]:
        """Accepts or refuses a request, or repeats its answer.

        An accepted mission is stored before it is confirmed.
        """
        return self.requests((request,), now)

    def requests(self, requests: Iterable[Request], now: float) -> List[Action]:
        """Handles several requests as `request` does, with one commit of the journal."""
        acceptance = self._acceptance_now()
        accepted: List[Tuple[Mission, Optional[Mission]]] = []
        for request in requests:
            before = self.book.find(request.id)
            try:
                mission = self._accept(request, before, acceptance)
            except RequestRefused as refusal:
                self._refuse(request, str(refusal))
            except JournalUnavailable as unavailable:
                self._refuse(request, unavailable.reason)
            else:
                if mission is not None:
                    accepted.append((mission, before))
        self._follow_times(now)
        actions = self._actions(now)
        if not (accepted and self.trouble):
            return actions
        for mission, before in accepted:
            self.book.withdraw(mission, before)
            self.desk.withdrawn(mission.serial)
            self._refuse(mission.request, self.trouble)
        return [*actions, *self._out.actions(now)]

    def _acceptance_now(self) -> Acceptance:
        """Returns the data with which requests are checked, with the places of the robots."""
        return replace(self.acceptance, places={
            robot.name: vertex for robot in self.robots.values()
            for vertex in [robot.record.some_vertex] if vertex is not None})

    def _accept(self, request: Request, before: Optional[Mission],
                acceptance: Acceptance) -> Optional[Mission]:
        """Accepts a request. For a repeated request, returns None and publishes its status again.

        before -- the last mission with the id of the request
        """
        if request.stamp and (before is None or before.request.identity != request.identity):
            ended = self._journal.find(request)
            if ended is not None:  # the request was latched, or was on its way for a long time
                self._out.put(PublishStatus(ended.status))
                return None
        if before is None or not request.is_repeat_of(before.request, before.state.is_open):
            request = self._work_requests.complete(request)
        mission = self.book.add(request, acceptance)
        if mission is not None:
            self.desk.accepted(mission)
        if mission is not None and request.requested_by:
            self._out.note(f'{request.requested_by} requests mission {request.id} to '
                           f'{listed(request.destinations)}.')
        if mission is None and before is not None and before.serial not in self.book.changed:
            self._out.put(PublishStatus(before.status))
        return mission

    def _run_timetables(self) -> None:
        """Requests the runs of timetables that are due."""
        for run in self.timetables.due():
            name, request = run.timetable.name, run.request
            try:
                if request is not None:
                    self._accept(request, self.book.find(request.id), self._acceptance_now())
            except JournalUnavailable:  # a later tick requests the run again
                return
            except RequestRefused as refusal:
                self._out.note(f'The run of timetable {name} that was due at '
                               f'{shown_at(run.due.last)} is refused: {refusal}.', True)
            if run.due.is_set_back:
                self._out.note(f'The clock was set back by more than a day: timetable {name} goes '
                               'on from now.', True)
            if run.due.missed:
                self._out.note(f'Timetable {name} has missed {run.due.missed} runs, which are not '
                               'made any more: the fleet manager or its journal was not there, or '
                               'the clock was set forward.', True)
            self.timetables.done(run)
            self._out.value_changed(stored_name(name), run.due.last)

    def _follow_times(self, now: float) -> None:
        """Lets missions begin or expire, and logs which missions will be late."""
        for text in self.times.follow(lambda mission: self._needed(mission, now), now):
            self._out.note(text, True)

    def _needed(self, mission: Mission, now: float) -> float:
        """Returns the seconds that a mission still needs, as far as is known.

        They count from now, or, if no robot serves the mission yet, from its beginning.
        """
        robot = self.robots.get(mission.robot)
        if robot is None:
            kinds = {self.robots[name].type for name in self.acceptance.robots_for(mission.request)}
            return time_over(mission, kinds, self.network) / self.rate
        end = time_to_go(robot, self.errand(robot), self.plan_executor.plan,
                         self.networks.edge_times, now).end
        return (time_over(mission, (robot.type,), self.network) if isnan(end) else end) / self.rate

    def _refuse(self, request: Request, reason: str) -> None:
        self._out.put(PublishStatus(mission_commands.refused(request, reason)))

    def stored_status(self, request_id: int, stamp: float) -> Optional[Status]:
        """Returns the stored status of a mission; None: none is stored.

        stamp -- 0: the last mission with this id

        A stored status is never withdrawn. Raises JournalUnavailable.
        """
        return self._journal.status(request_id, stamp)

    def command(self, request_id: int, command: CommandKind, now: float,
                change: Union[None, MissionChange, StepAnswer] = None,
                requested_by: str = '') -> List[Action]:
        """Cancels, pauses, resumes or modifies a mission, ends its dwell, or answers its step."""
        if requested_by:
            self._out.note(f'{requested_by} requests {command.name} of mission {request_id}.')
        mission = self.book.find(request_id)
        if mission is None or not mission.state.is_open:
            self._out.note(f'There is no open mission {request_id} for {command.name}.', True)
            return self._actions(now)
        before = mission.stored or mission.status
        if self.trouble and command not in (CommandKind.CANCEL, CommandKind.PAUSE):
            self._out.put(PublishStatus(mission_commands.not_done(before, command, self.trouble)))
            return self._actions(now)
        if change is None:
            problem = mission_commands.carry_out(command, mission, self.book, self.robots,
                                                 self.desk, requested_by)
        else:
            refusal = self.desk.answer(mission, change) if isinstance(change, StepAnswer) else (
                self._modify(mission, change))
            problem = refusal and f'Mission {request_id} is not changed: {refusal}.'
            if refusal:
                self._out.put(PublishStatus(mission_commands.not_done(before, command, refusal)))
        if mission.serial in self.book.changed:
            mission.changed_by = requested_by
        if problem:
            self._out.note(problem, change is not None)
        if mission.robot:
            self._out.robot_changed(mission.robot)
        self._advance(now)
        actions = self._actions(now)
        if self.trouble:
            told = mission_commands.not_stored(before, command, self.trouble)
            actions.append(PublishStatus(told))
        return actions

    def _modify(self, mission: Mission, change: MissionChange) -> str:
        """Changes a mission. Returns a clause that says why this is refused; empty: done."""
        try:
            change = replace(change, stops=self._work_requests.placed(change.stops))
            self._work_requests.check_types(change.stops)
        except RequestRefused as refusal:
            return str(refusal)
        return mission_commands.modify(mission, change, self.book, self.acceptance, self.robots,
                                       self.desk)

    # -- robots -----------------------------------------------------------------------------------

    def report(self, name: str, report: Report, now: float,
               arrived: Optional[float] = None) -> List[Action]:
        """Handles a robot's report of its place and route, which arrived at the time `arrived`."""
        robot, arrived = self.robots[name], now if arrived is None else arrived
        before = robot.master.progress
        try:
            check_report(report, self.network.graph)
            self._out.note_state(f'{name}/age', old_location(name, report),
                                 f'The locations of {name} are new again.')
            heard = robot.hear(report, arrived)
        except WrongReport as wrong:
            self._out.note_state(name, f'A report of {name} is ignored: {wrong}.', '')
            return self._actions(now)
        self._out.note_state(name, '', f'The reports of {name} make sense again.')
        if heard.news.refused:  # during an emergency stop each attempt is refused
            self._out.note_state(f'{name}/refusal',
                                 f'{name} refused an order: {heard.news.refused}.', '')
        if heard.news.is_older:
            self._doubt_orders(robot, report)
        elif heard.cause is EpochCause.STOP:
            self._stop_as_well(robot)
        beginning = robot.other_beginning()
        if beginning is not None and self.interlocking.is_free(robot, beginning):
            robot.master.begin_at(beginning)
        if robot.needs_person and robot.master.protocol.ahead and not robot.master.is_stopping:
            robot.master.halt()  # an order that is on its way must not let it drive
            self._out.send()
        self.networks.learn(robot, arrived)
        if before != robot.master.progress:
            self._out.robot_changed(name)
            mission_progress.follow(self.book, robot, now)
        self._separate()
        self._outages.compare_robot(robot)
        return self._checked(self._out.actions_unless_due_later(now), now)

    def step_report(self, name: str, report: StepReport, now: float) -> List[Action]:
        """Handles a robot's report of its steps."""
        if self.desk.report(name, report):
            self._work(now)
        return self._actions(now)

    def device_steps(self, device: str, report: StepReport, now: float) -> List[Action]:
        """Handles a device's report of its steps."""
        if self.desk.device_report(device, report, now):
            self._work(now)
        return self._actions(now)

    def set_load(self, name: str, request_id: Optional[int], now: float,
                 ) -> Tuple[str, List[Action]]:
        """Stores what a robot carries, as a person has said.

        request_id -- id of the mission whose load the robot carries; None: it carries nothing

        Also returns a sentence that says why this is refused; empty: done.
        """
        if self.trouble:
            return f'{self.trouble}.', self._actions(now)
        problem = self.desk.set_load(name, request_id)
        self._advance(now)
        return problem, self._actions(now)

    def device_report(self, report: DeviceReport, now: float) -> List[Action]:
        """Handles the report of a device. Its times are those of the supervisor's clock."""
        self.devices.report(report, now)
        return self._out.actions_unless_due_later(now)

    def _judge_devices(self, now: float) -> None:
        """Tells the interlocking which devices are open.

        Logs each robot at a place for which a device must be open, if the device does not report
        that it is open.
        """
        self.devices.update_open(now)
        lost = set() if self._is_starting else set(self._claims.lost())
        for claim in sorted(self._lost | lost):
            name, what = claim[0], self._claims.needs.resources[claim[1]]
            why = self.devices.view(claim[1], now).why
            wrong = (f'{name} is where it needs the {what}, which does not report that it is open'
                     f'{why and f" ({why})"}. No other robot is sent there. Look at both.')
            self._out.note_state(f'{name}/{what}', wrong if claim in lost else '',
                                 f'The {what} is open for {name} again, or {name} has left it.')
        self._lost = lost

    def _work(self, now: float) -> None:
        """Lets the work at stops go on, and closes the gates of the robots that must stand."""
        may_begin = not (self.is_stopped or self.trouble or self._is_starting)
        self._make_room()
        for name in self.desk.follow_all(may_begin):
            self._out.robot_changed(name)
            self._out.send()
        self._make_room()
        self.interlocking.at_work = self.desk.at_work
        self.interlocking.not_to_enter = self.desk.not_to_enter

    def _make_room(self) -> None:
        """Gives each robot the type that its load, or its next stop, requires."""
        for name in self.load_room.follow(self.interlocking):
            self._out.robot_changed(name)
        self.plan_executor.make_room(self.load_room.to_be_made())

    def _stop_as_well(self, robot: ManagedRobot) -> None:
        """Stops the fleet because a robot got a stop that bypassed the supervisor."""
        if self.is_stopped:
            return
        self._out.note(f'{robot.name} was stopped by a command that bypassed the fleet manager. '
                       'The whole fleet is stopped until you resume it.', True)
        self._stop(self._stop_now(StopCause.BYPASSED, f'{robot.name} was stopped by a command '
                                  'that bypassed the fleet manager'))

    def _doubt_orders(self, robot: ManagedRobot, report: Report) -> None:
        """Notes that a robot reports an order that the journal does not have.

        This shows that the journal is an old one.
        """
        why = f'{robot.name} reports order {report.said.order}, which the journal does not know'
        self._doubt_journal(why, robot.name)
        if not self.is_stopped:
            self._out.note(f'{why}: the journal was lost, or an older one was restored. All robots '
                           'are stopped, and go on when all stand.', True)
            self._is_recovering = True
            self._halt(self.robots.values())
            self._out.send()
        elif not robot.master.is_stopping:
            self._halt([robot])  # its former stop had a lower number, so the robot ignored it
            self._out.send()

    def _doubt_journal(self, why: str, reporting: str = '') -> None:
        """Treats the place of each robot as unknown until the robot has stopped once.

        The run number stays wrong until all places are known. If the fleet manager restarts before
        that, the places are unknown again.

        why       -- the reason as a clause
        reporting -- the robot whose report is just being handled
        """
        doubted = [name for name in self._everywhere
                   if name != reporting and name not in self._declared_absent]
        for name in doubted:
            self._everywhere[name].master.doubt()
        self._run.is_wrong = True
        self._out.value_changed(RUN_NUMBER, 0)
        if doubted:
            self._out.note(f'The journal is an old one: {why}. Nothing is granted until '
                           f'{", ".join(doubted)} stand and have obeyed a stop, or are declared '
                           'absent.', True)

    def _believe_journal(self) -> None:
        """Draws a new run number when the places of all robots are known again."""
        if self._run.is_wrong and not self.trouble and not any(
                robot.master.protocol.unknown for robot in self._everywhere.values()):
            with suppress(JournalUnavailable):  # a later tick tries again
                self._out.value_changed(RUN_NUMBER, self._run.draw())

    def _separate(self) -> None:
        """Lets the interlocking stop robots that exclude each other. These robots need a person."""
        for name in self.interlocking.separate(self._is_starting):
            robot = self.robots[name]
            robot.notice(Sign.EXCLUDED, self._too_near('it', robot))
            self._out.robot_changed(name)
            self._outages.compare_robot(robot)
            self._out.send()

    def _too_near(self, subject: str, robot: ManagedRobot) -> str:
        """Returns a clause that names all robots to which this one is too near; empty: none."""
        near = ' and '.join(self.interlocking.excluding(robot.name))
        return near and f'{subject} is too near to {near}: move one of them by hand'

    def _actions(self, now: float) -> List[Action]:
        """Returns all actions that follow an event. First it stops robots that exclude each other.
        """
        self._separate()
        return self._checked(self._out.actions(now), now)

    def _checked(self, actions: List[Action], now: float) -> List[Action]:
        """Stops the fleet if the event violated the model of allocations."""
        violations = self.interlocking.violations()
        if not violations:
            return actions
        for violation in violations:
            self._out.note(f'An error of the fleet manager: {violation}. The whole fleet is '
                           'stopped. Please report it, with this log and the journal.', True)
        if not self.is_stopped:
            self._stop(self._stop_now(StopCause.DEFECT, f'an error of the fleet manager: '
                                      f'{violations[0]}'))
        return [*actions, *self._out.actions(now)]

    def battery(self, name: str, charge: float, now: float) -> List[Action]:
        """Handles a report of the state of charge, 0..1."""
        self.robots[name].battery.report(charge, now)
        return self._out.actions_unless_due_later(now)

    # -- commands of people -----------------------------------------------------------------------

    def take_out(self, name: str, now: float) -> List[Action]:
        """Takes a robot out of service. It stops where it is."""
        robot = self.robots[name]
        robot.master.halt()
        robot.notice(Sign.TAKEN_OUT, 'it was taken out of service')
        self._out.robot_changed(name)
        self._outages.compare()
        self._advance(now)
        return self._actions(now)

    def bring_in(self, name: str, now: float) -> Tuple[str, List[Action]]:
        """Puts a robot back into service where it is.

        Also returns why this is refused; empty: done.
        """
        robot = self.robots[name]
        if self.is_stopped:
            return 'the fleet is stopped: resume it first', self._actions(now)
        # If its new place could not be stored, a restart would restore the old one.
        problem = self.trouble or robot.not_back_yet(now)
        if not problem and not robot.works and robot.master.protocol.unknown:
            problem = self._stop_first(robot)
        if not problem and not robot.works:
            problem = robot.come_back() or self._still_too_near(robot)
            self._out.robot_changed(name)
            self._outages.compare()
            self._advance(now)
        return problem, self._actions(now)

    def charge(self, name: str, until: float, now: float) -> Tuple[str, List[Action]]:
        """Asks a robot to charge until `until` (0..1) after its mission; 0: withdraws the request.

        Also returns a clause that says why this is refused; empty: done.
        """
        robot = self.robots[name]
        problem = self.trouble
        if until and not docks_of(robot, self.network):
            problem = problem or 'the fleet file and the graph have no dock for its type'
        elif not 0.0 <= until <= 1.0:
            problem = problem or f'it cannot charge until {100.0 * until:.0f} %'
        elif until and robot.battery.charge >= until:
            problem = problem or f'its charge is {100.0 * robot.battery.charge:.0f} % already'
        if not problem:
            robot.charge_until = until
            self._out.robot_changed(name)
            self._advance(now)
        return problem, self._actions(now)

    def pause_timetable(self, name: str, paused: bool, now: float) -> Tuple[str, List[Action]]:
        """Pauses a timetable, or lets it go on.

        Also returns a clause that says why this is refused; empty: done.
        """
        names = self.timetables.names
        problem = self.trouble or ('' if name in names else (
            f'the work file has no timetable {name!r}; it has: {", ".join(names) or "none"}'))
        if not problem:
            for stored, number in self.timetables.pause(name, paused).items():
                self._out.value_changed(stored, number)
        return problem, self._actions(now)

    def _stop_first(self, robot: ManagedRobot) -> str:
        robot.master.halt()
        self._out.robot_changed(robot.name)
        self._out.send()
        return (f'{robot.name} is told to stop first, because an old order may still reach it: try '
                'again in a moment')

    def _still_too_near(self, robot: ManagedRobot) -> str:
        problem = self._too_near(robot.name, robot)
        if problem:
            robot.notice(Sign.EXCLUDED, self._too_near('it', robot))
        return problem

    def declare_absent(self, name: str, now: float) -> Tuple[str, List[Action]]:
        """Declares on behalf of a person that a robot is not on the site.

        Also returns why this is refused; empty: done.
        """
        problem = ''
        if name in self.robots:
            problem = self.robots[name].declare_absent(now)
        elif self.removed.pop(name, None) is not None:
            del self._everywhere[name]
            self.interlocking.forget(name)
        if not problem:
            self._out.robot_changed(name)
            self._outages.compare()
            self._advance(now)
        return problem, self._actions(now)

    @property
    def unknown(self) -> List[str]:
        """Robots whose place is unknown. While there is one, nothing is granted."""
        return self.interlocking.unknown_robots

    def stop_fleet(self, now: float, stop: Optional[FleetStop] = None) -> List[Action]:
        """Sends an empty route to each robot at once, with or without a planner.

        stop -- author and time of the stop; None: no author, and the present time
        """
        self._stop(stop or self._stop_now(StopCause.PERSON))
        return self._actions(now)

    def _stop_now(self, cause: StopCause, why: str = '') -> FleetStop:
        return FleetStop(cause, since=self._journal.milliseconds() / 1000.0, why=why)

    def _stop(self, stop: FleetStop) -> None:
        """Stops all robots. If the fleet is stopped already, the record of that stop is kept."""
        self._close_gate()
        if not self.stop.is_in_force:
            self.stop = stop
            self._out.stop_changed(stop)
        self._halt(self.robots.values())
        self._out.send()

    def _close_gate(self) -> None:
        self.interlocking.is_stopped = True
        if not self.gate.is_closed:
            self.gate.close()

    def _halt(self, robots: Iterable[ManagedRobot]) -> None:
        for robot in robots:
            robot.master.halt()
            robot.is_halted = True
            self._out.robot_changed(robot.name)

    def resume_fleet(self, now: float,
                     ticket: Optional[int] = None) -> Tuple[str, List[Action]]:
        """Lets each robot go on from its place. Also returns why this is refused; empty: done.

        A robot that has not obeyed the stop yet goes on only after it has obeyed. `who_goes_on`
        names the robots that stay.

        ticket -- the gate's ticket at the person's command; a later stop has precedence
        """
        if not self.gate.open(self.gate.ticket if ticket is None else ticket):
            return 'the fleet was stopped again meanwhile', self._actions(now)
        self.interlocking.is_stopped = False
        self.stop = NOT_STOPPED
        self._out.stop_changed(NOT_STOPPED)
        self._advance(now)
        return '', self._actions(now)

    @property
    def who_goes_on(self) -> str:
        """Which robots go on after `resume_fleet`, and why others stay, as a sentence."""
        staying = [f'{robot.name}: {robot.why or robot.outage.value}'
                   for robot in self.robots.values()
                   if robot.outage is not None and robot.outage is not Outage.ABSENT]
        if self.trouble:
            told = ('The stop is released, but robots go on only after this is stored: '
                    + self.trouble)
        elif self.unknown:
            told = (f'The stop is released, but no robot goes on before {", ".join(self.unknown)} '
                    'report where they are and stand, or are declared absent')
        elif staying and len(staying) == len(self.robots):
            told = f'The stop is released, but no robot goes on: {"; ".join(staying)}'
        else:
            told = 'The fleet goes on' + (f', except {"; ".join(staying)}' if staying else '')
        return f'{told}.'

    # -- the graph and the plan -------------------------------------------------------------------

    def close_edges(self, edges: Iterable[int], now: float) -> List[Action]:
        """Sets the closed edges. Robots still drive closed edges that are granted already."""
        if self.networks.close(edges):
            self.interlocking.closed = self.network.closed
            self._advance(now)
        return self._actions(now)

    def plan_made(self, number: int, outcome: PlanningOutcome, now: float) -> List[Action]:
        """Handles the planner's answer. An answer that does not fit any more is ignored."""
        if self.plan_executor.plan_made(number, outcome, self._world(), now):
            self._advance(now)
        return self._actions(now)

    def plan_failed(self, number: int, reason: str, now: float) -> List[Action]:
        """Notes that the planner could not answer. The plan in force stays."""
        self.plan_executor.plan_failed(number, reason)
        return self._actions(now)

    def _keep_graph(self, graph: Graph) -> None:
        """Stores the new graph, and the data of all robots, which refer to it from now on."""
        self._out.graph_changed(graph)
        for name in self._everywhere:
            self._out.robot_changed(name)

    # -- time -------------------------------------------------------------------------------------

    def tick(self, now: float, heard: Optional[float] = None) -> List[Action]:
        """Does everything that depends on time; to be called ten to twenty times a second.

        heard -- time until which all arrived reports were handled; silence of a robot is judged at
                 this time
        """
        self._heard = now if heard is None else heard
        self._advance(now)
        return self._actions(now)

    def errands(self) -> Dict[str, Errand]:
        """Returns the errand of each robot."""
        return {name: self.errand(robot) for name, robot in self.robots.items()}

    def errand(self, robot: ManagedRobot) -> Errand:
        """Returns the errand of one robot."""
        return errand_of(self.book.of_robot(robot.name), robot.dock,
                         self.stations.limits.get(robot.name, NO_LIMIT))

    def _world(self) -> World:
        return self._view.world(self.book.serving, self.network, self.stations.limits)

    def _advance(self, now: float) -> None:
        for robot in self.robots.values():
            self._follow(robot, now)
        self._judge_devices(now)
        if not self.trouble:
            self._run_timetables()
        self._follow_times(now)
        self._work(now)
        if now - self._began > FRESH:  # before that, a device may not have reported yet
            for name in self.interlocking.keep_out():
                self._out.robot_changed(name)
        self._shorten()
        self._outages.compare()
        self._believe_journal()
        self._out.send()
        self._is_starting &= (self._heard - self._began < SILENCE and not all(
            robot.liveness.is_seen or robot.outage is Outage.ABSENT
            for robot in self.robots.values()))
        if self.is_stopped:
            self._waiting.hold(FLEET_STOPPED.text)
        self._is_recovering &= any(robot.is_halted and robot.outage is None
                                   for robot in self.robots.values())
        if self.all_wait.code:
            return
        for name in self.charging.update(self._waiting.short, self.network, now):
            self._out.robot_changed(name)
        for name in self._waiting.assign(self.acceptance, self.networks, now,
                                         self.room):
            mission_progress.follow(self.book, self.robots[name], now)
        self.stations.advance(self.network, self.charging.leaving)
        self.plan_executor.advance(self._world(), now)

    def _follow(self, robot: ManagedRobot, now: float) -> None:
        """Updates a robot to the present time, and lets it go on or stop."""
        robot.tick(now, self._heard)
        mission_progress.follow(self.book, robot, now)
        if not self.is_stopped and robot.return_to_work(now):
            self._out.robot_changed(robot.name)
        if robot.master.needs_stop and robot.liveness.stands:
            robot.master.halt()  # its reports do not count the orders of this fleet manager yet
            self._out.robot_changed(robot.name)
            self._out.send()

    def _shorten(self) -> None:
        """Shortens the routes of robots that must come to rest, to the end of their present edge.
        """
        if self.is_stopped:
            return
        for name, robot in self.robots.items():
            if not robot.comes_to_rest or not (robot.works or robot.master.order):
                continue  # a robot that does not work is skipped only if no order is on its way
            if not robot.master.shorten():
                robot.comes_to_rest = False
            self._out.robot_changed(name)
