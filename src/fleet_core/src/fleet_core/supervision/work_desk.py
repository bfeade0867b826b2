"""The work desk: leads missions with steps from stop to stop, and keeps the loads of the robots.

The rules are those of `fleet_core.work`. This module applies them to missions and robots: it tells
the rules where a robot is, updates the mission from its work, and closes the robot's motion gate.
"""
from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import (
    AbstractSet,
    Callable,
    Dict,
    FrozenSet,
    Iterator,
    List,
    Mapping,
    Optional,
    Set,
    Tuple,
)

from fleet_core.supervision.actions import SendStep
from fleet_core.supervision.machine_view import MachineReports, MachineView
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Mission, MissionChange, MissionState, StepAnswer
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.supervision.waits import NO_WAIT, Wait, WaitCode
from fleet_core.work import rules
from fleet_core.work.rules import Where, WorkPhase
from fleet_core.work.stops import Actor, LoadEffect, dwells_of
from fleet_core.work.tables import LOAD, LoadEvent, LoadState, StepState, after
from fleet_core.work.work import ANY_LOAD, Ending, RobotLoad, Seen, Situation, Work, work_of
from route_protocol.steps import MOST_KEY, StepAct, StepCommand, StepReport

NEWEST_STEP = 'newest_step'  # name, in the journal, of the highest known key of a step
REPEAT = 0.5  # s after which a command for a step is repeated, if the robot has not shown the step

_BY: Mapping[Actor, str] = {
    Actor.ROBOT: '', Actor.PERSON: ' by a person: say `mission answer {} done`',
    Actor.OUTSIDE: ' by a program: it says `mission answer {} done`',
    Actor.DEVICE: ' by device {}'}
_SHOWS_NONE = 'a step is due, but {} shows no steps: is the program running that carries them out?'
_NO_ROOM = ('a step is due, but another robot is too near for the load that {} takes: move the '
            'other one if it does not drive away')
_OTHER_RUNS = 'a step is due, but {} carries out another one'
_NO_KEY_LEFT = ('a step is due, but {} shows a step with a key above all that a fleet manager '
                'gives: restart the program that carries out its steps')
_STRANGE = ('the end of a step that the fleet manager does not know. If it does not end, restart '
            'the program that carries it out')
_STATES: Mapping[WorkPhase, MissionState] = {
    WorkPhase.ACTIVE: MissionState.ACTIVE, WorkPhase.CANCELLING: MissionState.CANCELLING,
    WorkPhase.NEEDS_PERSON: MissionState.NEEDS_PERSON, WorkPhase.SUCCEEDED: MissionState.SUCCEEDED,
    WorkPhase.FAILED: MissionState.FAILED, WorkPhase.CANCELLED: MissionState.CANCELLED}


class WorkDesk:
    """The works of all open missions with steps, and the loads of all robots.

    works -- as stored, by the serial of the mission
    loads -- as stored, by the robot's name
    newest -- the highest known key of a step, as stored
    clock -- returns ms since 1970
    machines -- the reports of the machines

    It has one method for each event of a mission with steps, because all of them change the works
    and the loads that are stored together.
    """

    def __init__(self, book: MissionBook, robots: Mapping[str, ManagedRobot],
                 works: Mapping[int, Work], loads: Mapping[str, RobotLoad], newest: int,
                 clock: Callable[[], int], machines: MachineReports) -> None:
        self._book, self._robots, self._clock = book, robots, clock
        self._works: Dict[int, Work] = dict(works)
        self._loads: Dict[str, RobotLoad] = dict(loads)
        self._stored: Dict[int, Work] = dict(works)
        self._reports: Dict[str, StepReport] = {}
        self._machines = machines
        self.newest = newest
        self.may_enter: Callable[[str, int], bool] = lambda _name, _place: True
        """Whether a robot may go to this place now. If not, no step begins while the robot stands
        near the place but not at it.
        """
        self.lacks_room: Callable[[str, AbstractSet[str]], bool] = lambda _name, _loads: False
        """Whether a robot has no room yet to take these types of load."""
        self._strange: Dict[str, FrozenSet[int]] = {}
        """By robot, the keys of running steps that no present mission of this fleet manager has
        ordered.
        """
        self._hindered: Dict[str, str] = {}
        """By robot, why the step that is due is not ordered, in words."""
        self._changed: Set[int] = set()
        self._changed_loads: Set[str] = set()
        self._sent: Dict[Tuple[str, int, StepAct], float] = {}
        for mission in book.serving.values():
            self._show(mission)
        for mission in book.open:  # an old version may have kept a mission AT_WORK without robot
            self.parted(mission)

    # -- loads and works of the robots -------------------------------------------------------------

    def load(self, name: str) -> RobotLoad:
        """Returns what a robot carries."""
        return self._loads.get(name, RobotLoad())

    def work(self, serial: int) -> Optional[Work]:
        """Returns the work of an open mission; None: it has no steps."""
        return self._works.get(serial)

    def machines(self, now: float) -> List[MachineView]:
        """Returns all machines of the site, and for which robots they work."""
        return self._machines.views(self._book, self._works, now)

    @property
    def laden(self) -> FrozenSet[str]:
        """Robots that possibly carry a load: they begin no other mission."""
        return frozenset(name for name, load in self._loads.items()
                         if load.state is not LoadState.EMPTY)

    @property
    def at_work(self) -> AbstractSet[str]:
        """Robots whose motion gate is closed."""
        return self._strange.keys() | {
            name for name, work in self._serving() if rules.gate_is_closed(work)}

    @property
    def not_to_enter(self) -> Mapping[str, int]:
        """For each robot, the vertex that it must not enter yet."""
        places = {name: rules.place_not_to_enter(work) for name, work in self._serving()}
        return {name: place for name, place in places.items() if place is not None}

    def next_stop(self, name: str) -> Optional[int]:
        """Returns the vertex of the stop that a robot makes now or next; None: it has none."""
        mission = self._book.of_robot(name)
        work = None if mission is None else self._works.get(mission.serial)
        if work is None or work.current == len(work.stops):
            return None
        return work.stops[work.current].place

    def to_take(self, name: str) -> FrozenSet[str]:
        """Returns the types of load that a robot takes at its present stop, or at the next one."""
        mission = self._book.of_robot(name)
        work = None if mission is None else self._works.get(mission.serial)
        return frozenset() if work is None else rules.to_take(work)

    def _serving(self) -> List[Tuple[str, Work]]:
        if not self._works:
            return []
        return [(name, self._works[mission.serial])
                for name, mission in self._book.serving.items() if mission.serial in self._works]

    def waits_for(self, name: str, mission: Optional[Mission]) -> Wait:
        """Returns what a robot waits for because of its work or its load."""
        if name in self._strange:
            return Wait(WaitCode.STEP, _STRANGE)
        load = self.load(name)
        if mission is None:
            return NO_WAIT if load.state is LoadState.EMPTY else Wait(WaitCode.PERSON, (
                f'its load is {load.state.value}, and its mission has ended. Say '
                f'`fleet load {name} empty` when it carries nothing'))
        work = self._works.get(mission.serial)
        if work is None or not (rules.gate_is_closed(work) or mission.is_held):
            return NO_WAIT
        phase = rules.phase_of(Situation(mission.serial, work, load))
        if phase is WorkPhase.NEEDS_PERSON:
            return Wait(WaitCode.PERSON, mission.reason)
        # If its step cannot be ordered, the robot does not work: it waits for a person.
        code = WaitCode.PERSON if name in self._hindered else WaitCode.STEP
        return Wait(code, mission.reason or 'the end of its work',
                    rules.time_left(work, self._clock()))

    # -- events -----------------------------------------------------------------------------------

    def accepted(self, mission: Mission) -> None:
        """Notes that a mission was accepted."""
        if mission.request.stops:
            self._put(mission.serial, work_of(mission.request.stops, mission.request.on_cancel))

    def withdrawn(self, serial: int) -> None:
        """Notes that an accepted mission could not be stored."""
        self._works.pop(serial, None)
        self._changed.discard(serial)

    def parted(self, mission: Mission) -> None:
        """Notes that a mission may have lost its robot. If so, no robot is at work for it now."""
        work = self._works.get(mission.serial)
        if work is not None and not mission.robot:
            self._put(mission.serial, rules.parted(work))

    def report(self, name: str, report: StepReport) -> bool:
        """Handles a robot's report of its steps. Returns whether the report changed anything."""
        before = self._reports.get(name)
        if not report.is_newer_than(before):
            return False
        self._reports[name] = report
        strange = self._note_strange(name, report, before is None)
        if before is None and report.last > self.newest:
            self.newest = min(report.last, MOST_KEY)
            self._doubt(name, name)
        mission = self._book.of_robot(name)
        if mission is None or mission.serial not in self._works:
            return strange
        return self._use(mission, rules.heard(self._situation(mission), report)) or strange

    def device_report(self, device: str, report: StepReport, now: float) -> bool:
        """Handles a device's report of its steps. Returns whether the report changed anything."""
        before = self._machines.newest(device)
        if not report.is_newer_than(before):
            return False
        self._machines.keep(device, report, now)
        if before is None and report.last > self.newest:
            self._doubt_all(device, report.last)
        changes = [self._use(mission, rules.heard(self._situation(mission), report, device))
                   for mission in tuple(self._book.serving.values())
                   if mission.serial in self._works]
        return any(changes) or before is None or before.steps != report.steps

    def _doubt_all(self, device: str, last: int) -> None:
        """Notes that a device has taken a step that is not in the journal.

        Any robot may have been at the device.
        """
        self.newest = max(self.newest, min(last, MOST_KEY))
        for name in self._robots:
            self._doubt(name, f'device {device}')

    def _note_strange(self, name: str, report: StepReport, is_first: bool) -> bool:
        """Notes the running steps that belong to no present mission. Returns whether these steps
        have changed.

        Such a step was ordered by another fleet manager, or for a mission that this fleet manager
        has ended or forgotten. So only the first report of a robot can add such a step.
        """
        before = self._strange.pop(name, frozenset())
        running = frozenset(step.key for step in report.steps if not step.word.is_final)
        if is_first:
            mission = self._book.of_robot(name)
            work = None if mission is None else self._works.get(mission.serial)
            own = () if work is None else (own.key for _, _, own in work.steps)
            now = running.difference(own)
        else:
            now = running & before
        if now:
            self._strange[name] = now
        return now != before

    def _doubt(self, name: str, taker: str) -> None:
        """Notes that `taker` has taken a step that is not in the journal.

        So it is unknown what the robot carries.
        """
        load = self.load(name).with_types((ANY_LOAD,))
        self._put_load(name, replace(load, state=after(LOAD, load.state, LoadEvent.BEGIN)))
        mission = self._book.of_robot(name)
        if mission is not None:
            self.fail(mission, f'the journal is older than a step that {taker} has taken')

    def follow_all(self, may_begin: bool) -> List[str]:
        """Updates the missions with steps. Returns the robots for which a step has begun.

        may_begin -- steps may begin now
        """
        for serial in [serial for serial in self._works if not self._book.is_open(serial)]:
            del self._works[serial]
            self._changed.add(serial)
        return [name for name, mission in (self._book.serving.items() if self._works else ())
                if mission.serial in self._works and self._follow(mission, may_begin)]

    def _follow(self, mission: Mission, may_begin: bool) -> bool:
        """Updates one mission with steps. Returns whether a step has begun."""
        robot, situation = self._robots[mission.robot], self._situation(mission)
        now = self._clock()
        if not situation.work.is_ending:
            situation = rules.passed(situation, mission.reached)
        followed = rules.expire(rules.follow(situation, self._where_is(robot, situation.work)), now)
        begun = None
        if may_begin and robot.works and mission.state in (
                MissionState.ACTIVE, MissionState.CANCELLING):
            begun = self._begin(robot, followed, now)
        if not self._use(mission, begun or followed):
            self._show(mission)
        return begun is not None

    def _begin(self, robot: ManagedRobot, situation: Situation, now: int) -> Optional[Situation]:
        """Returns the situation after the due step is ordered.

        None: no step is due, or the step cannot be ordered now.
        """
        name, work = robot.name, situation.work
        place = rules.due_step(situation, self._where_is(robot, work))
        self._hindered.pop(name, None)
        if place is None:
            return None
        step = work.step(place)
        has_driver, device = step.actor.has_driver, step.device
        report = (self._machines.newest(device) if device else self._reports.get(name)
                  ) if has_driver else None
        key = rules.next_key(work, report.last if report is not None else 0, now)
        taken = {step.load_type} if step.load is LoadEffect.TAKES else set()
        hindrances = ((bool(taken) and self.lacks_room(name, taken), _NO_ROOM),
                      (name in self._strange, _STRANGE), (key > MOST_KEY, _NO_KEY_LEFT),
                      (has_driver and report is None, _SHOWS_NONE),
                      (bool(device) and self._is_busy(device), _OTHER_RUNS))
        hindrance = next((words for is_so, words in hindrances if is_so), '')
        if hindrance:
            self._hindered[name] = hindrance.format(f'device {device}' if device else name)
            return None
        self.newest = max(self.newest, key)
        return rules.begin(situation, place, key, 0 if report is None else report.run, now)

    def _is_busy(self, device: str) -> bool:
        """Returns whether a device carries out a step, or may still get a command for a step."""
        report = self._machines.newest(device)
        return report is not None and any(not one.word.is_final for one in report.steps) or any(
            step.device == device and own.seen is not Seen.OVER and own.key
            for work in self._works.values() for _, step, own in work.steps)

    def _where_is(self, robot: ManagedRobot, work: Work) -> Where:
        """Returns where a robot is, as the rules need it."""
        stands = robot.is_at_rest and robot.position is not None and not robot.record.ahead
        position = robot.position
        if not stands or position is None or work.current == len(work.stops):
            return Where(stands)
        place = work.stops[work.current].place
        is_there = position.vertex == place
        graph = robot.record.graph
        edges = (graph.edges_from(position.vertex) if position.vertex is not None
                 else (position.edge, -position.edge))
        is_near = any(graph.end_vertex(edge).id == place for edge in edges)
        return Where(True, is_there, is_there or is_near,
                     not is_near or self.may_enter(robot.name, place))

    # -- commands of people -----------------------------------------------------------------------

    def cancel(self, mission: Mission, reason: str) -> bool:
        """Cancels a mission if it has steps and a robot; otherwise returns False."""
        if mission.serial not in self._works or not mission.robot:
            return False
        if mission.state is MissionState.PAUSED:
            self._book.set(mission, MissionState.CANCELLING, reason)
        self._use(mission, rules.cancel(self._situation(mission), reason))
        return True

    def fail(self, mission: Mission, reason: str) -> bool:
        """Lets a mission fail if it has steps and a robot; otherwise returns False.

        The mission has failed when its running steps have ended. Until then its robot stands.
        """
        if mission.serial not in self._works or mission.robot not in self._robots:
            return False
        self._use(mission, rules.fail(self._situation(mission), reason))
        return True

    def change(self, mission: Mission, change: MissionChange) -> str:
        """Replaces stops that have not begun.

        Returns a clause that says why this is refused; empty: done.
        """
        changed, problem = rules.changed(self._situation(mission), change.stops, change.first_stop)
        if not problem:
            mission.request = replace(mission.request, stops=changed.work.stops)
            self._book.changed.add(mission.serial)
            self._use(mission, changed)
        return problem

    def choices(self, mission: Mission) -> str:
        """Returns the group of a mission's next stop; the stop may be at any place of this group.

        Empty: the place of this stop is fixed.
        """
        work = self._works.get(mission.serial)
        if work is None or work.current == len(work.stops) or (
                rules.has_begun(work.progress[work.current])):
            return ''
        return work.stops[work.current].group

    def choose(self, mission: Mission, place: int) -> None:
        """Chooses another one of the equal places for the next stop of a mission."""
        self._use(mission, rules.chosen(self._situation(mission), place))

    def answer(self, mission: Mission, answer: StepAnswer) -> str:
        """Handles an answer to a step.

        Returns a clause that says why the answer is refused; empty: done.
        """
        if mission.serial not in self._works or not mission.robot:
            return 'it has no step that waits for an answer'
        answered, problem = rules.answer(self._situation(mission), answer.answer, answer.key)
        self._use(mission, answered)
        return problem

    def set_load(self, name: str, request_id: Optional[int]) -> str:
        """Stores what a robot carries, as a person has said.

        request_id -- id of the mission whose load the robot carries; None: it carries nothing

        Returns a sentence that says why this is refused; empty: done.
        """
        mission = self._book.of_robot(name)
        serial = mission.serial if mission is not None else 0
        if request_id is not None:
            if mission is None or mission.request.id != request_id:
                return f'{name} does not serve mission {request_id}.'
            load = rules.said_loaded(self.load(name), serial, self._works.get(serial))
        else:
            load = rules.said_empty(self.load(name))
        if mission is not None and serial in self._works:
            if any(step.load and own.state is StepState.RUNNING
                   for _, step, own in self._works[serial].steps):
                return f'{name} is just taking or giving its load: wait until that has ended.'
            self._use(mission, rules.settle(self._situation(mission)._replace(load=load)))
        else:
            self._put_load(name, load)
            if mission is not None:
                self._show(mission)
        return ''

    # -- keeping ----------------------------------------------------------------------------------

    def _situation(self, mission: Mission) -> Situation:
        return Situation(mission.serial, self._works[mission.serial], self.load(mission.robot))

    def _use(self, mission: Mission, situation: Situation) -> bool:
        """Keeps a situation, and updates the mission. Returns whether this changed anything."""
        if situation == self._situation(mission):
            return False
        self._put(mission.serial, situation.work)
        self._put_load(mission.robot, situation.load)
        self._show(mission)
        return True

    def _put(self, serial: int, work: Work) -> None:
        if self._works.get(serial) != work:
            self._works[serial] = work
            self._changed.add(serial)

    def _put_load(self, name: str, load: RobotLoad) -> None:
        if self.load(name) != load:
            self._loads[name] = load
            self._changed_loads.add(name)

    def _show(self, mission: Mission) -> None:
        """Updates a mission from its work, and from the load of its robot."""
        work, load = self._works.get(mission.serial), self.load(mission.robot)
        mission.is_bound = load.is_bound_to(mission.serial) or (
            work is not None and any(rules.open_steps(work)))
        if work is None:
            return
        phase = rules.phase_of(Situation(mission.serial, work, load))
        mission.has_worked = any(own.times_ordered for _, _, own in work.steps)
        self._hold(mission, phase is WorkPhase.NEEDS_PERSON or work.is_ending)
        self._ask(mission, work)
        self._let_follow(mission, work, phase)
        self._set_phase(mission, phase, _words(work, load, phase, mission))

    def _hold(self, mission: Mission, is_held: bool) -> None:
        if is_held and not mission.is_held:
            self._let_rest(mission)
        mission.is_held = is_held

    def _let_rest(self, mission: Mission) -> None:
        """Lets the robot of a mission come to rest at the end of its edge."""
        robot = self._robots.get(mission.robot)
        if robot is not None:
            robot.comes_to_rest = True

    def _ask(self, mission: Mission, work: Work) -> None:
        place = work.answerable
        asks = work.progress_of(place).key if place is not None else 0
        if asks != mission.asks:
            mission.asks = asks
            self._book.changed.add(mission.serial)

    def _set_phase(self, mission: Mission, phase: WorkPhase, reason: str) -> None:
        """Sets the state and reason of a mission.

        While the robot of the mission has an outage, nothing changes unless the mission ends.
        """
        state, robot = _STATES[phase], self._robots.get(mission.robot)
        if mission.state is MissionState.PAUSED and state.is_open:
            state = MissionState.PAUSED
        if not state.is_open or robot is not None and robot.outage is None:
            self._book.set(mission, state, reason or self._hindered.get(mission.robot, ''))

    def _let_follow(self, mission: Mission, work: Work, phase: WorkPhase) -> None:
        """Updates the destinations of a mission, and the number of visited destinations."""
        if phase in (WorkPhase.FAILED, WorkPhase.CANCELLED):
            return
        places, dwells = tuple(stop.place for stop in work.stops), dwells_of(work.stops)
        if places and (mission.request.destinations, mission.request.dwells) != (places, dwells):
            self._let_rest(mission)
            self._book.divert(mission, places, dwells, work.current)
        elif not work.is_ending:
            behind = work.current - mission.reached
            if behind > 0:
                self._book.reach(mission, behind)
            elif mission.stays_since is not None and not rules.is_at_work(work):
                self._book.end_stay(mission)

    # -- the journal and the robots ---------------------------------------------------------------

    @property
    def is_changed(self) -> bool:
        """Whether any change is not stored yet."""
        return bool(self._changed or self._changed_loads)

    @property
    def changes(self) -> Tuple[Dict[int, Optional[Work]], Dict[str, RobotLoad]]:
        """The works and loads that are not stored yet."""
        return ({serial: self._works.get(serial) if self._book.is_open(serial) else None
                 for serial in sorted(self._changed)},
                {name: self._loads[name] for name in sorted(self._changed_loads)})

    def stored(self) -> None:
        """Notes that all changes are stored."""
        for serial in self._changed:
            work = self._works.get(serial)
            if work is None:
                self._stored.pop(serial, None)
            else:
                self._stored[serial] = work
        self._changed.clear()
        self._changed_loads.clear()

    def due(self, now: float) -> List[SendStep]:
        """Returns the commands to be sent now. The works to which they belong are stored.

        While a robot cannot work, for example because the fleet is stopped, no command that begins
        a step is sent.
        """
        found: List[SendStep] = []
        before, self._sent = self._sent, {}
        for name, mission in self._book.serving.items() if self._stored else ():
            work = self._stored.get(mission.serial)
            for device, command in () if work is None else self._commands(name, work):
                if command.act is StepAct.DO and not self._robots[name].works:
                    continue
                key = name, command.key, command.act
                at = before.get(key, -inf)
                is_due = now - at >= REPEAT
                self._sent[key] = now if is_due else at
                if is_due:
                    found.append(SendStep(name, command, device))
        return found

    def _commands(self, name: str, work: Work) -> Iterator[Tuple[str, StepCommand]]:
        """Yields (device, command) for a robot and for the devices of its work.

        The device is '' if the command is for the robot.
        """
        devices = {step.device for _, step, own in work.steps if own.seen is not Seen.OVER}
        for device in sorted(devices):
            report = self._machines.newest(device) if device else self._reports.get(name)
            for command in () if report is None else rules.commands(work, report, device):
                yield device, command


def _words(work: Work, load: RobotLoad, phase: WorkPhase, mission: Mission) -> str:
    """Returns what a mission waits for, or why it ended, in words; empty: nothing."""
    place = work.asking
    if place is not None:
        own = work.progress_of(place)
        return (f'step {place.step + 1} ({work.step(place).type}) of stop {place.stop + 1} needs '
                f'an answer: {own.text}. Say `mission answer {mission.request.id} '
                'retry|skip|fail|done`')
    if phase is WorkPhase.NEEDS_PERSON:
        return (f'its load is {load.state.value}: unload {mission.robot}, and say '
                f'`fleet load {mission.robot} empty`')
    running = [f'step {place.step + 1} ({step.type}) of stop {place.stop + 1}'
               f'{_BY[step.actor].format(step.device or mission.request.id)}'
               for place, step, own in work.steps if own.state is StepState.RUNNING]
    return '; '.join(running) or (work.reason if work.ending is not Ending.NONE else '')
