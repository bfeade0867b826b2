"""The work desk: leads missions with steps from stop to stop, and keeps the loads of the robots.

The rules are those of `fleet_core.work`. This module joins them with missions and robots: it tells
the rules where a robot is, lets the mission follow its work, and closes the robot's motion gate.
"""
from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import AbstractSet, Callable, Dict, FrozenSet, List, Mapping, Optional, Set, Tuple

from fleet_core.supervision.actions import SendStep
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Mission, MissionState, StepAnswer
from fleet_core.supervision.robots import ManagedRobot
from fleet_core.work import rules
from fleet_core.work.rules import Where, WorkPhase
from fleet_core.work.stops import Actor, WorkStop, dwells_of
from fleet_core.work.tables import LoadState, StepState
from fleet_core.work.work import Ending, RobotLoad, Situation, Work, work_of
from route_protocol.steps import StepReport

REPEAT = 0.5  # s between two commands for a step that the robot has not shown

_BY: Mapping[Actor, str] = {
    Actor.ROBOT: '', Actor.PERSON: ' by a person: say `mission answer {} done`',
    Actor.OUTSIDE: ' by a program: it says `mission answer {} done`'}
_STATES: Mapping[WorkPhase, MissionState] = {
    WorkPhase.ACTIVE: MissionState.ACTIVE, WorkPhase.CANCELLING: MissionState.CANCELLING,
    WorkPhase.NEEDS_PERSON: MissionState.NEEDS_PERSON, WorkPhase.SUCCEEDED: MissionState.SUCCEEDED,
    WorkPhase.FAILED: MissionState.FAILED, WorkPhase.CANCELLED: MissionState.CANCELLED}


class WorkDesk:
    """The works of all open missions with steps, and the loads of all robots.

    works -- as stored, by the serial of the mission
    loads -- as stored, by the robot's name
    clock -- returns ms since 1970
    """

    def __init__(self, book: MissionBook, robots: Mapping[str, ManagedRobot],
                 works: Mapping[int, Work], loads: Mapping[str, RobotLoad],
                 clock: Callable[[], int]) -> None:
        self._book, self._robots, self._clock = book, robots, clock
        self._works: Dict[int, Work] = dict(works)
        self._loads: Dict[str, RobotLoad] = dict(loads)
        self._stored: Dict[int, Work] = dict(works)
        self._reports: Dict[str, StepReport] = {}
        self._key = max((own.key for work in works.values() for _, _, own in work.steps),
                        default=0)
        self._mute: Set[str] = set()  # robots that are to begin a step but show none
        self._changed: Set[int] = set()
        self._changed_loads: Set[str] = set()
        self._sent: Dict[Tuple[int, int], float] = {}
        for name, mission in book.serving.items():
            self._show(name, mission)

    # -- what the fleet has to know ---------------------------------------------------------------

    def load(self, name: str) -> RobotLoad:
        """What a robot carries."""
        return self._loads.get(name, RobotLoad())

    def work(self, serial: int) -> Optional[Work]:
        """The work of an open mission; None: it has no steps."""
        return self._works.get(serial)

    @property
    def laden(self) -> FrozenSet[str]:
        """Robots that may carry a load: they begin no other mission."""
        return frozenset(name for name, load in self._loads.items()
                         if load.state is not LoadState.EMPTY)

    @property
    def at_work(self) -> AbstractSet[str]:
        """Robots whose motion gate is closed."""
        return {name for name, work in self._serving() if rules.gate_is_closed(work)}

    @property
    def not_to_enter(self) -> Mapping[str, int]:
        """By robot, the vertex that it must not enter yet."""
        places = {name: rules.place_not_to_enter(work) for name, work in self._serving()}
        return {name: place for name, place in places.items() if place is not None}

    def _serving(self) -> List[Tuple[str, Work]]:
        if not self._works:
            return []
        return [(name, self._works[mission.serial])
                for name, mission in self._book.serving.items() if mission.serial in self._works]

    def waits_for(self, name: str, mission: Optional[Mission]) -> str:
        """What a robot waits for because of its work or its load, in words; empty: nothing."""
        if mission is None:
            load = self.load(name)
            if load.state is LoadState.EMPTY:
                return ''
            return (f'a person: its load is {load.state.value}, and its mission has ended. Say '
                    f'`fleet load {name} empty` when it carries nothing')
        work = self._works.get(mission.serial)
        at_work = work is not None and (rules.gate_is_closed(work) or mission.is_held)
        return mission.reason or 'the end of its work' if at_work else ''

    # -- events -----------------------------------------------------------------------------------

    def accepted(self, mission: Mission) -> None:
        """A mission was accepted."""
        if mission.request.stops:
            self._put(mission.serial, work_of(mission.request.stops, mission.request.on_cancel))

    def withdrawn(self, serial: int) -> None:
        """An accepted mission could not be stored."""
        self._works.pop(serial, None)
        self._changed.discard(serial)

    def report(self, name: str, report: StepReport) -> bool:
        """Handles a robot's report of its steps. Returns whether it changed anything."""
        if not report.is_newer_than(self._reports.get(name)):
            return False
        self._reports[name] = report
        mission = self._book.of_robot(name)
        if mission is None or mission.serial not in self._works:
            return False
        return self._use(name, mission, rules.heard(self._situation(name, mission), report))

    def go_on(self, may_begin: bool) -> List[str]:
        """Follows all robots with such missions. Returns those for which a step has begun.

        may_begin -- steps may begin now
        """
        for serial in [serial for serial in self._works if not self._book.is_open(serial)]:
            del self._works[serial]
            self._changed.add(serial)
        return [name for name, mission in (self._book.serving.items() if self._works else ())
                if mission.serial in self._works and self._follow(name, mission, may_begin)]

    def _follow(self, name: str, mission: Mission, may_begin: bool) -> bool:
        robot, situation = self._robots[name], self._situation(name, mission)
        now = self._clock()
        if situation.work.ending is Ending.NONE:
            situation = rules.passed(situation, mission.reached)
        after = rules.follow(situation, _where_is(robot, situation.work))
        after = rules.expire(after, now)
        where = _where_is(robot, after.work)
        begins = False
        if may_begin and robot.works and mission.state in (
                MissionState.ACTIVE, MissionState.CANCELLING):
            place = rules.due_step(after, where)
            run = None if place is None else self._run_for(name, after.work.step(place).actor)
            self._set_mute(name, place is not None and run is None)
            if place is not None and run is not None:
                self._key = max(now, self._key + 1, self._last_key(name) + 1)
                after = rules.begin(after, place, self._key, run, now)
                begins = True
        if not self._use(name, mission, after):
            self._show(name, mission)
        return begins

    def _run_for(self, name: str, actor: Actor) -> Optional[int]:
        """The run for which a step is ordered; None: the robot has not shown its run yet."""
        report = self._reports.get(name)
        if actor is not Actor.ROBOT:
            return 0
        return None if report is None else report.run

    def _set_mute(self, name: str, is_mute: bool) -> None:
        (self._mute.add if is_mute else self._mute.discard)(name)

    def _last_key(self, name: str) -> int:
        report = self._reports.get(name)
        return 0 if report is None else report.last

    # -- commands of people -----------------------------------------------------------------------

    def cancel(self, mission: Mission, reason: str) -> bool:
        """Cancels a mission with steps that a robot serves. Returns whether it is one."""
        if mission.serial not in self._works or not mission.robot:
            return False
        if mission.state is MissionState.PAUSED:
            self._book.set(mission, MissionState.CANCELLING, reason)
        name = mission.robot
        self._use(name, mission, rules.cancel(self._situation(name, mission), reason))
        return True

    def change(self, mission: Mission, stops: Tuple[WorkStop, ...]) -> str:
        """Replaces the stops that have not begun. Returns why not, as a clause; empty: done."""
        after, problem = rules.changed(self._situation(mission.robot, mission), stops)
        if not problem:
            mission.request = replace(mission.request, stops=after.work.stops)
            self._book.changed.add(mission.serial)
            self._use(mission.robot, mission, after)
        return problem

    def answer(self, mission: Mission, answer: StepAnswer) -> str:
        """Handles an answer to a step. Returns why not, as a clause; empty: done."""
        if mission.serial not in self._works or not mission.robot:
            return 'it has no step that waits for an answer'
        situation = self._situation(mission.robot, mission)
        after, problem = rules.answer(situation, answer.answer, answer.key)
        self._use(mission.robot, mission, after)
        return problem

    def set_load(self, name: str, request_id: Optional[int]) -> str:
        """A person says what a robot carries: nothing (None), or the load of its mission.

        Returns why not, as a sentence; empty: done.
        """
        mission = self._book.of_robot(name)
        serial = mission.serial if mission is not None else 0
        if request_id is not None:
            if mission is None or mission.request.id != request_id:
                return f'{name} does not serve mission {request_id}.'
            load = rules.said_loaded(self.load(name), serial)
        else:
            load = rules.said_empty(self.load(name))
        if mission is not None and serial in self._works:
            if any(step.load and own.state is StepState.RUNNING
                   for _, step, own in self._works[serial].steps):
                return f'{name} is just taking or giving its load: wait until that has ended.'
            situation = self._situation(name, mission)._replace(load=load)
            self._use(name, mission, rules.settle(situation))
        else:
            self._put_load(name, load)
        return ''

    # -- keeping ----------------------------------------------------------------------------------

    def _situation(self, name: str, mission: Mission) -> Situation:
        return Situation(mission.serial, self._works[mission.serial], self.load(name))

    def _use(self, name: str, mission: Mission, after: Situation) -> bool:
        """Keeps a situation, and lets the mission follow. Returns whether it changed anything."""
        before = self._situation(name, mission)
        if after == before:
            return False
        self._put(mission.serial, after.work)
        self._put_load(name, after.load)
        self._show(name, mission)
        return True

    def _put(self, serial: int, work: Work) -> None:
        if self._works.get(serial) != work:
            self._works[serial] = work
            self._changed.add(serial)

    def _put_load(self, name: str, load: RobotLoad) -> None:
        if self.load(name) != load:
            self._loads[name] = load
            self._changed_loads.add(name)

    def _show(self, name: str, mission: Mission) -> None:
        """Lets a mission follow its work."""
        work = self._works.get(mission.serial)
        if work is None:
            return
        situation = self._situation(name, mission)
        phase, robot = rules.phase_of(situation), self._robots.get(name)
        mission.is_bound = situation.load.is_bound_to(mission.serial) or any(
            own.state in (StepState.RUNNING, StepState.ASK) for _, _, own in work.steps)
        was_held = mission.is_held
        mission.is_held = phase is WorkPhase.NEEDS_PERSON or (
            work.ending is not Ending.NONE and not work.is_cut)
        if mission.is_held and not was_held and robot is not None:
            robot.comes_to_rest = True
        place = work.answerable
        asks = work.progress_of(place).key if place is not None else 0
        if asks != mission.asks:
            mission.asks = asks
            self._book.changed.add(mission.serial)
        self._let_follow(mission, work, phase)
        state, reason = _STATES[phase], _words(work, situation.load, name, mission)
        if name in self._mute and not reason:
            reason = (f'a step is due, but {name} shows no steps: is the program running that '
                      'carries them out?')
        if mission.state is MissionState.PAUSED and state.is_open:
            state = MissionState.PAUSED
        if not state.is_open or robot is not None and robot.outage is None:
            self._book.set(mission, state, reason)

    def _let_follow(self, mission: Mission, work: Work, phase: WorkPhase) -> None:
        """Sets how many destinations are behind a mission, and which ones it has."""
        if phase in (WorkPhase.FAILED, WorkPhase.CANCELLED):
            return
        places, dwells = tuple(stop.place for stop in work.stops), dwells_of(work.stops)
        if places and (mission.request.destinations, mission.request.dwells) != (places, dwells):
            robot = self._robots.get(mission.robot)
            if robot is not None:
                robot.comes_to_rest = True
            self._book.divert(mission, places, dwells, work.current)
        elif work.ending is Ending.NONE or work.is_cut:
            behind = work.current - mission.reached
            if behind > 0:
                self._book.reach(mission, behind)
            elif mission.stays_since is not None and not rules.is_at_work(work):
                self._book.end_stay(mission)

    # -- the journal and the robots ---------------------------------------------------------------

    @property
    def is_changed(self) -> bool:
        """Is any change not stored yet?"""
        return bool(self._changed or self._changed_loads)

    @property
    def changes(self) -> Tuple[Dict[int, Optional[Work]], Dict[str, RobotLoad]]:
        """The works and loads that are not stored yet."""
        return ({serial: self._works.get(serial) if self._book.is_open(serial) else None
                 for serial in sorted(self._changed)},
                {name: self._loads[name] for name in sorted(self._changed_loads)})

    def stored(self) -> None:
        """All changes are stored."""
        for serial in self._changed:
            work = self._works.get(serial)
            if work is None:
                self._stored.pop(serial, None)
            else:
                self._stored[serial] = work
        self._changed.clear()
        self._changed_loads.clear()

    def due(self, now: float) -> List[SendStep]:
        """The commands that the robots are to be given now. What they rest on is stored."""
        found: List[SendStep] = []
        before, self._sent = self._sent, {}
        for name, mission in self._book.serving.items() if self._stored else ():
            work, report = self._stored.get(mission.serial), self._reports.get(name)
            if work is None or report is None:
                continue
            for command in rules.commands(work, report):
                at = before.get((command.key, command.act), -inf)
                is_due = now - at >= REPEAT
                self._sent[command.key, command.act] = now if is_due else at
                if is_due:
                    found.append(SendStep(name, command))
        return found


def _where_is(robot: ManagedRobot, work: Work) -> Where:
    """Where a robot is, as the rules need it."""
    stands = robot.is_at_rest and robot.position is not None and not robot.record.ahead
    position = robot.position
    if not stands or position is None or work.current == len(work.stops):
        return Where(stands)
    place = work.stops[work.current].place
    is_there = position.vertex == place
    graph = robot.record.graph
    edges = (graph.edges_from(position.vertex) if position.vertex is not None
             else (position.edge, -position.edge))
    return Where(True, is_there, is_there or any(
        graph.end_vertex(edge).id == place for edge in edges))


def _words(work: Work, load: RobotLoad, name: str, mission: Mission) -> str:
    """What a mission waits for, or why it ended, in words; empty: nothing."""
    place = work.asking
    if place is not None:
        own = work.progress_of(place)
        return (f'step {place.step + 1} ({work.step(place).type}) of stop {place.stop + 1} needs '
                f'an answer: {own.text}. Say `mission answer {mission.request.id} '
                'retry|skip|fail|done`')
    if mission.is_held and load.is_bound_to(mission.serial) and not mission.asks and (
            rules.phase_of(Situation(mission.serial, work, load)) is WorkPhase.NEEDS_PERSON):
        return (f'its load is {load.state.value}: unload {name}, and say '
                f'`fleet load {name} empty`')
    running = [f'step {place.step + 1} ({step.type}) of stop {place.stop + 1}'
               f'{_BY[step.actor].format(mission.request.id)}'
               for place, step, own in work.steps if own.state is StepState.RUNNING]
    if running:
        return '; '.join(running)
    return work.reason if work.ending is not Ending.NONE else ''
