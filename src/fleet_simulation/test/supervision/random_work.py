"""A random test of the work of a fleet, which checks the invariants after each event.

The fleet manager is the real supervisor with its journal. Three robots work at a press with a
queue, at a group of shelves, and with a machine; a door and a zone are on their paths. The world
records the truth, which the fleet manager does not know: which steps are being carried out, how
often each step was done, and for each robot its load and its place.

A *step* of the test is one event of the fleet manager: a message, a command of a person, a tick, or
a start. Events have weights: events that continue the work are more frequent than disturbances.
Some disturbances wait for a rare moment, and then come together (`RandomWork.combine`). Messages
are lost, repeated and reordered; messages to robots and devices may also be delayed.

Persons look before they answer, so their answers are true.

Invariants, after each step (letters as in the docstrings of `claims` and `work_model`):

(a) (b) (c) (d) the invariants of claims. The conformance check tests them. This module tests them
    with the true places of the robots: the journal has the claim of each robot at a resource, no
    resource has more robots than its capacity, and the door of a robot is open
(e) a step is stored under its key before it begins; with each key it begins only once, and a done
    step never begins again; a person is asked about an unknown outcome
(f) a robot counts as EMPTY or LOADED only if it is; a mission with a load keeps its robot
(g) a robot at work stands at its stop, and does not move during a step whose blocking is not NONE;
    it gets the command for such a step only at its stop, or in front of the stop
(h) no two robots have the same queue place
(i) a mission waits only for missions that were accepted before it
(j) a mission or step that has ended does not change any more
(k) no robot is sent onto an edge that is closed to its load, or so near to another robot that their
    loads could touch (`VirtualFleet` checks the true places)
After the last fault, people answer all questions, and each mission ends.
"""
from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from random import Random
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Set, Tuple

from fleet_core.fleet import RobotType
from fleet_core.geometry.exclusions import ROUNDING
from fleet_core.interlocking.claims import ClaimState
from fleet_core.interlocking.reports import Report
from fleet_core.interlocking.resources import Resource, ResourceKind
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision.actions import Action, AskDevice, PublishStatus, SendStep
from fleet_core.supervision.device_desk import FRESH
from fleet_core.supervision.missions import (
    CommandKind,
    Mission,
    MissionChange,
    MissionState,
    Request,
    StepAnswer,
)
from fleet_core.supervision.settings import RobotSettings
from fleet_core.work import rules
from fleet_core.work.dependencies import Dependency, Until
from fleet_core.work.devices import Device, DeviceKind, StepDevice
from fleet_core.work.loads import LoadType
from fleet_core.work.rules import StepDecision
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import Station, StationKind
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    When,
    WorkStep,
    WorkStop,
    dwells_of,
    problem_of,
)
from fleet_core.work.tables import LoadState, StepState
from fleet_core.work.work import StepPlace, Work
from fleet_simulation.agv.steps import SimulatedSteps
from fleet_simulation.report_times import Rhythm
from fleet_simulation.virtual_fleet import Crash
from route_protocol.devices import DeviceMode, DeviceReport
from route_protocol.steps import HAND_OVER, StepAct, StepCommand, StepReport, Word
from route_protocol.values import TAKEN_OVER, Reason, ReasonCode, RouteReport
from trajectory_graph import Edge, Graph, Vertex
from world.supervised_fleet import SupervisedFleet

# The press at the end of a lane, and an exit on the other side:
#
#     11 -- 12 -- 13 =gate= 14 -- 15 =hall=16
#      |     |     |         |     |      |
#      1 --- 2 --- 3 =hall=  4 --- 5 --- 18 (press)      queue: 5, 4      shelves: 1, 11
SPEED = 4.0
PLACES = {**{k: (2.0 * k, 0.0) for k in (1, 2, 3, 4, 5)}, 18: (12.0, 0.0),
          **{10 + k: (2.0 * k, 3.0) for k in (1, 2, 3, 4, 5, 6)}}
ENDS = {**{k: (k, k + 1) for k in (1, 2, 3, 4)}, 5: (5, 18), 6: (18, 16),
        **{10 + k: (10 + k, 11 + k) for k in (1, 2, 3, 4, 5)},
        **{20 + k: (k, 10 + k) for k in (1, 2, 3, 4, 5)}}
SITE = Graph([Vertex(id, *place, 0.0) for id, place in PLACES.items()],
             [Edge(id, *ends, velocity_forward=SPEED, velocity_backwards=SPEED)
              for id, ends in ENDS.items()])
PRESS = Station('press', (18,), (5, 4))
SHELVES = Station('shelves', (1, 11), (), 2, StationKind.GROUP)
WORK = SiteWork({'press': PRESS, 'shelves': SHELVES},
                {'gate': Device('gate', DeviceKind.DOOR, (13,), 10.0)},
                {'oven': StepDevice('oven', 10.0)})
HALL = Resource('hall', ResourceKind.ZONE, frozenset({3, 15}))
WITHOUT_EXIT = Graph([vertex for vertex in SITE.vertices.values() if vertex.id != 16],
                     [edge for edge in SITE.edges.values() if edge.id not in (6, 15)])
KIND = RobotType('agv', 0.4, SPEED)
STARTS = {'a': 2, 'b': 12, 'c': 14}
PARKING = (2, 3, 12, 13, 14, 15)
GOALS = (2, 3, 12, 13, 14, 15, 16, 16, 18, 18, 18)
PERIODS = (0.2, 0.4, 0.4, 0.8)  # s; times between two calls of `beat`
UNSEEN = 0.1  # after this share of its openings, the door fails before the robot may enter
FAULT = (1.0, 3.0, 8.0)         # s; durations of a fault
MOST_OPEN = 4
CALM = 900                      # beats within which all missions end when nothing is wrong

Identity = Tuple[int, StepPlace]  # serial of a mission, and the place of a step in it
Message = Callable[[], None]


class Kept(NamedTuple):
    """A delayed message. `subject`: the robot or machine whose steps the message is about."""

    send: Message
    subject: str = ''


class Body(NamedTuple):
    """The true state of a step.

    by    -- the robot or machine that carries out the step now; empty: none
    times -- how often the step was done
    """

    step: WorkStep
    robot: str
    by: str = ''
    times: int = 0


class Hands(SimulatedSteps):
    """The steps of one robot or machine. Their starts and ends are recorded in the world."""

    def __init__(self, world: RandomWork, name: str) -> None:
        super().__init__(lambda: 1, lambda _: world.draw.choice((0.1, 0.5, 1.0, 3.0)))
        self._world, self._name = world, name

    def _begin(self, command: StepCommand) -> None:
        self._world.begins(self._name, command)
        super()._begin(command)

    def _end(self, key: int, word: Word) -> None:
        super()._end(key, word)
        self._world.ends(self._name, key, word is Word.DONE or (
            word is Word.UNKNOWN and self._world.coin()))

    def restart(self) -> None:
        """Restarts the driver. Each step that it was carrying out counts as done or not done, at
        random.
        """
        for key in self._running:
            self._world.ends(self._name, key, self._world.coin())
        super().restart()


class RandomWork(SupervisedFleet):
    """One random run of the fleet, which its seed determines.

    reckless -- whether the interlocking is also asked for edges that are in no plan, as a test of
                its conditions without the planner; then missions need not end
    load     -- the type of the loads, if loads restrict the robots; then missions need not end
    """

    def __init__(self, seed: int, reckless: bool = False,
                 load: Optional[LoadType] = None) -> None:
        self.reckless, self.is_calm = reckless, False
        self.load = load
        self.draw = Random(f'work {seed}')
        self.count = 0
        """Number of steps so far."""
        self.history: List[str] = []
        """What happened, in words."""
        self.bodies: Dict[Identity, Body] = {}
        self.carried: Dict[str, int] = dict.fromkeys(STARTS, 0)
        self.moved: Set[str] = set()
        """Robots that people have moved, until they are brought back."""
        self._unstored: Set[str] = set()
        """Robots whose load a person has declared; this declaration is not stored yet."""
        self._forgotten: Set[str] = set()
        """Robots whose load a person has to declare again, because it was not stored."""
        self.lies = False
        """Whether the door reports that it is open although it is not."""
        self._deceived: Set[str] = set()  # robots that are on their way into the closed door
        self._failed = -math.inf          # when the door failed, or ended its false reports
        self._doors, self._disks = Random(f'doors {seed}'), Random(f'disks {seed}')
        self._is_slow = False             # the commit of the next tick takes long
        self._dead: Set[str] = set()      # machines that report nothing
        self._by_key: Dict[Tuple[str, int], Identity] = {}
        self._known: Dict[int, Work] = {}
        self._final: Dict[int, MissionState] = {}
        self._stood: Dict[Identity, Tuple[float, float]] = {}
        self._late: List[Kept] = []
        self._ends: List[Tuple[float, Message]] = []
        self._requests: List[Request] = []
        super().__init__(
            SITE, {name: (KIND, vertex) for name, vertex in STARTS.items()}, seed=seed,
            repeats=0.05, loss=0.05, parking=PARKING, resources=(HALL,),
            settings=RobotSettings(release_ahead=self.draw.choice((0.0, 1.0, 3.0))),
            rhythm=Rhythm(0.3, 1.0),
            work=replace(WORK, loads={} if load is None else {load.name: load}))
        self.steps = {name: Hands(self, name) for name in self.agvs}
        self.step_devices = {name: Hands(self, name) for name in WORK.step_devices}

    def coin(self) -> bool:
        """Returns True with a probability of 0.5."""
        return self.draw.random() < 0.5

    def log(self, text: str) -> None:
        """Notes what happens."""
        self.history.append(f'{self.count} {self.now:.1f} s: {text}')

    # -- messages ---------------------------------------------------------------------------------

    def do(self, actions: Sequence[Action]) -> None:
        """Performs the actions after one event, and checks the invariants."""
        super().do(actions)
        self.count += 1
        if not self.supervisor.trouble:
            self._unstored.clear()
        self.check()

    def _begin(self) -> None:
        self._known = {}
        self._forgotten |= self._unstored
        super()._begin()

    def _perform(self, actions: Sequence[Action]) -> None:
        for action in actions:
            if isinstance(action, (SendStep, AskDevice)) and self.draw.random() < 0.1:
                self._late.append(Kept(partial(self._perform_late, action), (
                    action.device or action.robot) if isinstance(action, SendStep) else ''))
                continue
            if isinstance(action, PublishStatus):
                self._check_final(action)
            if isinstance(action, SendStep) and action.command.act is StepAct.DO:
                self._check_sent(action)
            super()._perform((action,))

    def _perform_late(self, action: Action) -> None:
        super()._perform((action,))

    def beat(self) -> None:
        """Lets time pass: robots and devices move, and messages come in any order."""
        self._pass(self.draw.choice(PERIODS))
        for at, end in [one for one in self._ends if one[0] <= self.now]:
            self._ends.remove((at, end))
            end()
        if not self.is_calm and self._fails_now():
            self._fail_unseen()
        messages = [*self._late_messages(), *self._messages()]
        self.draw.shuffle(messages)
        for send in messages:
            send()
        if self._is_slow:  # this commit probably stores the grant
            self._is_slow, self.disk.seconds = False, FRESH + 1.5
        self.do(self.supervisor.tick(self.now))

    def _pass(self, period: float) -> None:
        """Lets robots and devices move, while the fleet manager does nothing."""
        self.now += period
        for order in self.network.arrived_orders(self.now):
            self._deliver(order)
            self._reports.touch(order.robot)
        self.drive_all()
        if self.load is not None:
            self.loads = {name: self.load.radius or 0.0
                          for name, carried in self.carried.items() if carried}
        self._check_room()
        for hands in (*self.steps.values(), *self.step_devices.values()):
            hands.advance(period)
        for device in self.devices.values():
            device.advance(period)
        self._check_places()

    def _hang(self, seconds: float) -> None:
        """Lets `seconds` pass, because a commit of the fleet manager takes so long."""
        self.log('the commit takes long')
        for _ in range(round(seconds / min(PERIODS))):
            self._pass(min(PERIODS))

    def _late_messages(self) -> List[Message]:
        """Returns the delayed messages that come now. Some of these come again later."""
        late, self._late = self._late, []
        self._late = [message for message in late if self.draw.random() < 0.8]
        return [one.send for one in late if one not in self._late or self.draw.random() < 0.3]

    def _messages(self) -> List[Message]:
        """Returns the messages that are sent now and reach the fleet manager now."""
        found: List[Message] = []
        for name, agv in self.agvs.items():
            if not self.network.is_silent(name, self.now) and (
                    self._reports.is_due(name, agv, self.now)):
                self._reports.reported(name, agv, self.now)
                self._send(found, partial(self._say, name, agv.report(self.now), self.now))
        for name, hands in self.steps.items():
            if not self.network.is_silent(name, self.now) and self._must_report(name, hands):
                self._send(found, partial(self._say_steps, name, hands.report()), name)
        for name, hands in self.step_devices.items():
            if name not in self._dead and self._must_report(f'device {name}', hands):
                self._send(found, partial(self._say_device_steps, name, hands.report()), name)
        for device in self.devices.values():
            for one in device.reports(self.now):
                mode = DeviceMode.OPEN if self.lies else one.mode
                self._send(found, partial(self._say_device, replace(one, mode=mode)))
        for number, outcome in self.planner.answers.arrived(self.now):
            found.append(partial(self._answer_plan, number, outcome))
        return found

    def _send(self, now: List[Message], message: Message, subject: str = '') -> None:
        """Delivers a message to the fleet manager now, later, twice, or never."""
        now += [message] * self.network.copies()
        if self.draw.random() < 0.05:
            self._late.append(Kept(message, subject))

    def _say(self, name: str, said: RouteReport, at: float) -> None:
        self.do(self.supervisor.report(name, Report(said, self.now - at), self.now))

    def _say_steps(self, name: str, said: StepReport) -> None:
        self.do(self.supervisor.step_report(name, said, self.now))

    def _say_device_steps(self, name: str, said: StepReport) -> None:
        self.do(self.supervisor.device_steps(name, said, self.now))

    def _say_device(self, said: DeviceReport) -> None:
        self.do(self.supervisor.device_report(said, self.now))

    def _answer_plan(self, number: int, outcome: PlanningOutcome) -> None:
        self.do(self.supervisor.plan_made(number, outcome, self.now))

    # -- what really happens ----------------------------------------------------------------------

    def begins(self, by: str, command: StepCommand) -> None:
        """Notes that a robot or a machine begins to carry out a step."""
        serving = {one.serial: name for name, one in self.supervisor.book.serving.items()}
        found = next((((serial, place), step, own)
                      for serial, work in self.disk.journal.works().items()
                      for place, step, own in work.steps
                      if own.key == command.key and step.actor.has_driver
                      and (step.device or serving.get(serial)) == by), None)
        assert found is not None, f'(e) {by} begins {command}, which is not stored'
        identity, step, own = found
        body = self.bodies.get(identity, Body(step, self._mission(identity[0]).robot))
        assert not own.state.is_final, f'(e) {by} begins {step.type}, which has ended'
        assert step.harmless or not (body.by or body.times), (
            f'(e) {step.type} is carried out a second time')
        assert not step.device or all(one.by != by for one in self.bodies.values()), (
            f'(e) {by} carries out two steps at once')
        others = [one.step for (serial, place), one in self.bodies.items()
                  if one.by and serial == identity[0] and place != identity[1]]
        assert not others or StepBlocking.HARD not in [
            one.blocking for one in (step, *others)], f'(e) {step} runs together with {others}'
        self.bodies[identity] = body._replace(by=by)
        self._by_key[by, command.key] = identity
        self.log(f'{by} begins {step.type} {command.key} of M{identity[0]}')

    def ends(self, by: str, key: int, has_happened: bool) -> None:
        """Notes that a robot or a machine ends a step.

        has_happened -- whether the step was done
        """
        identity = self._by_key.pop((by, key))
        self._stood.pop(identity, None)
        body = self.bodies[identity]
        self.bodies[identity] = body._replace(by='', times=body.times + has_happened)
        self.log(f'{body.step.type} {key} ends at {by}, done: {has_happened}')
        if has_happened:
            self._move_load(body)

    def _move_load(self, body: Body) -> None:
        change = {LoadEffect.NONE: 0, LoadEffect.TAKES: 1, LoadEffect.GIVES: -1}[body.step.load]
        self.carried[body.robot] = max(self.carried[body.robot] + change, 0)

    def _mission(self, serial: int) -> Mission:
        return next(one for one in self.supervisor.book.open if one.serial == serial)

    # -- missions ---------------------------------------------------------------------------------

    def request_mission(self) -> None:
        """A mission is requested. Sometimes it was already requested before."""
        draw, book = self.draw, self.supervisor.book
        if self._requests and draw.random() < 0.1:
            again = draw.choice(self._requests)
            before = book.find(again.id)
            self.do(self.supervisor.request(again, self.now))
            assert before is None or book.find(again.id) is before, f'{again} is made twice'
            return
        if len(book.open) >= MOST_OPEN:
            return
        id = len(self._requests) + 1
        stops = self._stops(draw.randint(1, 3), draw.random() < 0.6)
        on_cancel = tuple(replace(one, condition=draw.choice(list(Condition)))
                          for one in self._stops(draw.randint(0, 1), False))
        moment = self.wall + self.now
        after = tuple(Dependency(draw.randint(1, id - 1), draw.choice(list(Until)))
                      for _ in range(draw.randint(0, 2)) if id > 1 and draw.random() < 0.3)
        request = Request(
            id, tuple(one.place for one in stops), dwells=dwells_of(stops), stops=stops,
            on_cancel=on_cancel, priority=draw.choice((0, 0, 5)), stamp=float(id), after=after,
            robot=draw.choice(('', '', '', *STARTS)),
            earliest=moment + 3.0 if draw.random() < 0.1 else 0.0,
            deadline=moment + draw.uniform(5.0, 60.0) if draw.random() < 0.1 else 0.0)
        self._requests.append(request)
        self.log(f'mission {id} is requested: {[one.place for one in stops]} {after}')
        self.do(self.supervisor.request(request, self.now))

    def _stops(self, count: int, takes: bool) -> Tuple[WorkStop, ...]:
        """Returns random stops. The first stop may take a load, the other stops may give a load."""
        draw = self.draw
        stops: List[WorkStop] = []
        for k in range(count):
            is_taken = takes and not stops
            effects = [LoadEffect.TAKES] if is_taken else [LoadEffect.GIVES] if (
                draw.random() < 0.4) else []
            effects += [LoadEffect.NONE] * draw.randint(0, 2)
            draw.shuffle(effects)
            steps = tuple(self._step(effect, f'{effect.name.lower()}{k}{n}')
                          for n, effect in enumerate(effects))
            is_group = draw.random() < 0.2
            stops.append(WorkStop(0 if is_group else draw.choice(GOALS), steps=steps,
                                  group='shelves' if is_group else ''))
        return tuple(stops)

    def _step(self, load: LoadEffect, name: str) -> WorkStep:
        draw = self.draw
        while True:
            actor = draw.choice((Actor.ROBOT,) * 5 + (Actor.PERSON, Actor.OUTSIDE, Actor.DEVICE))
            policy = draw.choice(list(Policy))
            is_device = actor is Actor.DEVICE
            step = WorkStep(
                HAND_OVER if is_device else name, draw.choice((2.0, 8.0, 20.0)),
                when=draw.choice(list(When)), actor=actor, blocking=draw.choice(list(StepBlocking)),
                on_failure=policy, retries=int(policy is Policy.RETRY),
                harmless=draw.random() < 0.2, breakable=draw.random() < 0.5, load=load,
                device='oven' if is_device else '',
                load_type=self.load.name if self.load and load is LoadEffect.TAKES else '')
            if not problem_of(step):
                return step

    def _command(self, command: CommandKind, change: Any = None, id: int = 0) -> None:
        book = self.supervisor.book
        if id or book.open:
            id = id or self.draw.choice(book.open).request.id
            self.log(f'{command.name} of mission {id} {_short(change)}')
            self.do(self.supervisor.command(id, command, self.now, change))

    def cancel(self) -> None:
        """A person cancels a mission."""
        self._command(CommandKind.CANCEL)

    def pause(self) -> None:
        """A person pauses a mission."""
        self._command(CommandKind.PAUSE)

    def resume(self) -> None:
        """A person resumes a mission."""
        self._command(CommandKind.RESUME)

    def change(self) -> None:
        """A mission gets other stops. Loads may be brought to some of these stops."""
        stops = self._stops(self.draw.randint(1, 2), False)
        self._command(CommandKind.MODIFY, MissionChange(
            self.draw.choice((0, 5)), stops=stops, first_stop=self.draw.choice((0, 0, 0, 1, 2))))

    def answer(self) -> None:
        """A person, or a program outside, answers a question of the fleet manager truthfully."""
        asked = [(mission, work, work.answerable) for mission in
                 self.supervisor.book.serving.values()
                 for work in (self.supervisor.desk.work(mission.serial),)
                 if work is not None and work.answerable is not None]
        if asked:
            self._answer(*self.draw.choice(asked))
        else:
            self.unload()

    def _answer(self, mission: Mission, work: Work, place: StepPlace) -> None:
        step, own, identity = work.step(place), work.progress_of(place), (mission.serial, place)
        body = self.bodies.get(identity, Body(step, mission.robot))
        if body.by and self.coin():
            self.log(f'a person restarts the steps of {body.by}')
            self._hands(body.by).restart()  # the step hangs; the person looks again later
            return
        said = [StepDecision.DONE] if body.times and not body.by else [
            StepDecision.RETRY] if not body.times else []
        if not body.times and not body.by:
            said += [StepDecision.SKIP, StepDecision.FAIL]
            said += [StepDecision.DONE] * 4 if not step.actor.has_driver else []
        if not said:
            return
        answer = self.draw.choice(said)
        if answer is StepDecision.DONE and not body.times:
            self.bodies[identity] = body._replace(times=1)
            self._move_load(body)
        self._command(CommandKind.ANSWER, StepAnswer(answer, self.draw.choice((0, own.key))),
                      mission.request.id)
        if step.load and self.supervisor.trouble:
            self._unstored.add(mission.robot)

    def unload(self) -> None:
        """A person looks at the load of a robot, and declares it or removes it."""
        name = self.draw.choice(sorted(self.agvs))
        mission = self.supervisor.book.of_robot(name)
        if any(one.by and one.robot == name and one.step.load for one in self.bodies.values()):
            return
        load = self.supervisor.desk.load(name)
        is_needed = name in self._forgotten or load.state is LoadState.UNKNOWN or (
            load.state is LoadState.LOADED and (
                mission is None or mission.state is MissionState.NEEDS_PERSON))
        if not is_needed:
            return
        says_loaded = self.carried[name] and mission is not None and self.coin()
        problem, actions = self.supervisor.set_load(
            name, mission.request.id if says_loaded and mission is not None else None, self.now)
        if not problem:
            self.carried[name] = self.carried[name] if says_loaded else 0
            self._forgotten.discard(name)
            self._unstored |= {name} if self.supervisor.trouble else set()
        self.log(f'a person says that {name} is {"loaded" if says_loaded else "empty"} {problem}')
        self.do(actions)

    def _hands(self, name: str) -> SimulatedSteps:
        return {**self.steps, **self.step_devices}[name]

    # -- faults -----------------------------------------------------------------------------------

    def later(self, end: Message) -> None:
        """Lets a fault end after some time."""
        self._ends.append((self.now + self.draw.choice(FAULT), end))

    def steps_fail(self) -> None:
        """Lets the next step of a robot or machine fail, end unknown, or never end."""
        hands = self.draw.choice([*self.steps.values(), *self.step_devices.values()])
        hands.fail_next(self.draw.choice((Word.FAILED, Word.UNKNOWN, Word.RUNNING)), 1)

    def driver_restarts(self) -> None:
        """The program that carries out the steps of a robot or machine restarts."""
        subjects = [one.subject for one in self._late if one.subject] + [
            one.by for one in self.bodies.values() if one.by]
        self._hands(self.draw.choice(subjects or sorted(self.steps))).restart()

    def machine_dies(self) -> None:
        """A machine reports nothing for a while."""
        name = self.draw.choice(sorted(self.step_devices))
        self._dead.add(name)
        self.later(lambda: self._dead.discard(name))

    def door_is_silent(self) -> None:
        """The door reports nothing for a while."""
        self.devices['gate'].is_silent = True
        self.later(lambda: setattr(self.devices['gate'], 'is_silent', False))

    def door_restarts(self) -> None:
        """The door forgets which request it obeys."""
        self.devices['gate'].restart()

    def door_fails(self) -> None:
        """The door closes by itself, and reports nothing for a while."""
        gate = self.devices['gate']
        gate.is_silent, gate.request, self._failed = True, None, self.now
        self.later(self._door_works)

    def _fails_now(self) -> bool:
        """Returns whether the door fails now, after it has opened for a robot that may not enter
        yet.

        The decision has its own random numbers, so that all other events of a seed stay the same.
        """
        claims = self.supervisor.interlocking.claims
        return self.devices['gate'].mode is DeviceMode.OPEN and any(
            claims.state(name, 'gate') is ClaimState.ASKED for name in self.agvs) and (
                self._doors.random() < UNSEEN)

    def _fail_unseen(self) -> None:
        """The door reports that it is open, and then fails.

        The disk is full or slow, so the robot waits until this report is too old.
        """
        self.log('the door fails unseen')
        gate, self._failed = self.devices['gate'], self.now
        self._is_slow = self._disks.random() < 0.5
        if not self._is_slow:
            self.disk.fails()
        for one in gate.reports(self.now):
            self._say_device(one)
        gate.is_silent, gate.request = True, None
        self._ends += [(self.now + FRESH + 2.0, lambda: self.disk.fails(False)),
                       (self.now + 2.0 * FRESH + 2.0, self._door_works)]

    def _door_works(self) -> None:
        self.devices['gate'].is_silent = False
        self.devices['gate'].restart()

    def door_sticks(self) -> None:
        """The door does not move for a while."""
        self.devices['gate'].seconds = 1e9
        self.later(lambda: setattr(self.devices['gate'], 'seconds', 2.0))

    def door_lies(self) -> None:
        """For a while, the door always reports that it is open."""
        self.lies = True
        self.later(self._door_is_honest)

    def _door_is_honest(self) -> None:
        self.lies, self._failed = False, self.now  # a false report may still be on its way

    def _is_on_way_into_door(self, name: str) -> bool:
        """Returns whether a robot is in the door, or was sent an order into it.

        A grant whose order was not sent does not count.
        """
        gate, agv = WORK.devices['gate'].edges[0], self.agvs[name]
        master = self.supervisor.robots[name].master
        edges = (agv.edge, *agv.edges[agv.current:], *(
            edge for order in self.network.under_way(name) for edge in order.edges), *(
            step.edge for order in master.protocol.open if order.number <= master.last_sent
            for step in order.steps(master.record.done)))
        return gate in map(abs, edges)

    def manager_restarts(self) -> None:
        """The fleet manager crashes, and starts again."""
        self.log('the fleet manager restarts')
        self.restart()

    def exit_is_removed(self) -> None:
        """The fleet manager starts with a graph in which the press has no exit.

        A mission to the exit becomes impossible.
        """
        if not any({6, 15} & {abs(agv.edge), *map(abs, agv.edges), *map(
                abs, self.supervisor.robots[name].record.held), *(
                abs(edge) for order in self.network.under_way(name) for edge in order.edges)}
                for name, agv in self.agvs.items()):
            self.restart(WITHOUT_EXIT)
            self.later(lambda: self.restart(SITE))

    def manager_dies(self) -> None:
        """The fleet manager crashes at one of its next commits, after some of its actions."""
        self.crash = Crash(self.disk.commits + self.draw.randint(0, 3), self.draw.randint(0, 2))

    def disk_is_full(self) -> None:
        """Nothing can be stored for a while."""
        self.disk.fails()
        self.later(lambda: self.disk.fails(False))

    def fleet_is_stopped(self) -> None:
        """A person stops the fleet."""
        self.log('the fleet is stopped')
        self.do(self.supervisor.stop_fleet(self.now))

    def station_breaks(self) -> None:
        """The edges to the press are closed for a while."""
        self.close(5, 6)
        self.later(lambda: self.close())

    def robot_is_silent(self) -> None:
        """A robot sends and hears nothing for a while."""
        self.network.silent[self._any()] = self.now + self.draw.choice(FAULT)

    def robot_stalls(self) -> None:
        """A robot stands still for a while."""
        self.agvs[self._any()].stalled = self.draw.choice(FAULT)

    def robot_refuses(self) -> None:
        """A robot refuses its next orders."""
        self.agvs[self._any()].refusing = self.draw.randint(1, 4)

    def robot_fails(self) -> None:
        """The route of a robot fails, or a person takes it over."""
        self.agvs[self._any()].fail(self.draw.choice((
            TAKEN_OVER, Reason(ReasonCode.OTHER, 'an object blocks the path'))))

    def robot_forgets(self) -> None:
        """A robot is switched off, and on again."""
        self.agvs[self._any()].forget()

    def robot_is_taken_out(self) -> None:
        """A person takes a robot out of service."""
        self.do(self.supervisor.take_out(self._any(), self.now))

    def robot_is_moved(self) -> None:
        """A person takes a robot out of service, and moves it to the next vertex if that vertex is
        free.
        """
        name = self._any()
        agv, supervisor = self.agvs[name], self.supervisor
        if agv.is_driving or self.network.is_silent(name, self.now) or (
                self.load is not None and any(self.carried.values())):
            return  # people move no robot that could hit a load
        edge = self.draw.choice(list(SITE.edges_from(agv.visited[-1])))
        end = SITE.end_vertex(edge)
        held = {abs(one) for other, robot in supervisor.robots.items() if other != name
                for one in (*robot.record.held, self.agvs[other].edge)}
        near = {abs(one) for one in (*SITE.edges_from(end.id), *SITE.edges_from(agv.visited[-1]))}
        if near & held or any(self.network.under_way(other) for other in self.agvs):
            return
        self.log(f'{name} is moved to {end.id}')
        self.do(supervisor.take_out(name, self.now))
        self.moved.add(name)
        self._stood.clear()
        agv.be_carried(edge, SITE.curve(edge).length)
        agv.visited.append(end.id)
        self._say(name, agv.report(self.now), self.now)  # the fleet manager learns the new place

    def _any(self) -> str:
        return self.draw.choice(sorted(self.agvs))

    def recklessly_ask(self) -> None:
        """Asks the interlocking for an edge that is in no plan."""
        supervisor = self.supervisor
        at_work = sorted({one.robot for one in self.bodies.values() if one.by})
        robot = supervisor.robots[self.draw.choice(at_work) if at_work else self._any()]
        begin, here = robot.record.last_vertex, robot.position
        edges = [] if begin is None else list(self.graph.edges_from(begin))
        if here is not None and here.vertex is None:
            edges = [here.edge, -here.edge]
        if self.reckless and edges and not robot.comes_to_rest:
            if supervisor.interlocking.grant(robot, (self.draw.choice(edges),)).edges:
                supervisor._out.robot_changed(robot.name)
            self.do(supervisor.tick(self.now))

    # -- what people repair -----------------------------------------------------------------------

    def repair(self) -> None:
        """A person resumes the fleet, or brings a robot in."""
        supervisor = self.supervisor
        if supervisor.is_stopped:
            self.log('the fleet is resumed')
            self.do(supervisor.resume_fleet(self.now)[1])
            return
        out = [name for name, robot in supervisor.robots.items() if robot.needs_person]
        if out:
            name = self.draw.choice(out)
            problem, actions = supervisor.bring_in(name, self.now)
            self.log(f'{name} is brought in {problem}')
            if not problem:
                self.moved.discard(name)
            self.do(actions)

    def picture(self) -> str:
        """Returns the state of the missions and robots as text."""
        lines, desk = [f'{self.now:.1f} s'], self.supervisor.desk
        for mission in self.supervisor.book.open:
            work = desk.work(mission.serial)
            lines.append(f'M{mission.serial} {mission.state.name} of {mission.robot!r}, '
                         f'{mission.reason!r}, left {mission.left}, held {mission.is_held}')
            for k, (stop, own) in enumerate(zip(work.stops, work.progress) if work else ()):
                lines.append(f'  {k}: at {stop.place} {stop.group} {own.state.name}')
                lines += [f'    {step.type} {step.when.name} {step.actor.name} '
                          f'{step.blocking.name} {one.state.name} {one.seen.name}'
                          for step, one in zip(stop.steps, own.steps)]
        for name, agv in self.agvs.items():
            robot = self.supervisor.robots[name]
            lines.append(
                f'{name}: on {agv.edge} at {agv.arc:.2f}, {agv.motion.name}, outage {robot.outage} '
                f'{robot.why}, at {robot.position}, ahead {robot.record.ahead}, halted '
                f'{robot.is_halted}, carries {self.carried[name]}, {desk.load(name)}, limit '
                f'{self.supervisor.stations.limits.get(name)}, claims '
                f'{self.supervisor.interlocking.claims.of(name)}, waits for '
                f'{self.supervisor.plan_executor.waits_for.get(name)}')
        return '\n'.join(lines)

    # -- the choice of events ---------------------------------------------------------------------

    def live(self, steps: int) -> None:
        """Lets this number of steps happen, and then waits until all missions have ended."""
        while self.count < steps:
            self._happen(EVENTS)
        if not (self.reckless or self.load):
            self.calm()

    def _happen(self, weights: Mapping[str, float]) -> None:
        event, = self.draw.choices(list(weights), list(weights.values()))
        if event not in ('beat', 'answer', 'request_mission', 'combine'):
            self.log(event)
        getattr(self, event)()

    def combine(self) -> None:
        """Waits for a rare moment, and lets faults and commands come together."""
        is_mixed = self.coin()
        moment, events = (self.draw.choice(MOMENTS), ()) if is_mixed else (
            self.draw.choice(COMBINATIONS))
        for _ in range(30):
            if moment(self):
                break
            self._happen(QUIET)
        for event in events:
            self.log(event)
            getattr(self, event)()
        for _ in range(self.draw.choice((1, 2, 2, 3)) if is_mixed else 0):
            self._happen(TROUBLE)
            if self.coin():
                self.beat()

    def calm(self) -> None:
        """Ends all faults. People help, until all missions have ended."""
        self.log('calm')
        self.is_calm = True
        self.crash = None
        for _, end in self._ends:
            end()
        self._ends.clear()
        self.network.end_faults()
        for agv in self.agvs.values():
            agv.refusing, agv.stalled = 0, 0.0
        self.close()
        for _ in range(CALM):
            if not self.supervisor.book.open:
                return
            self.beat()
            self.repair()
            if self.coin():
                self.answer()
            for mission in self.supervisor.book.open:
                if mission.state is MissionState.PAUSED:
                    self._command(CommandKind.RESUME, id=mission.request.id)
        assert not self.supervisor.book.open, 'missions do not end'

    # -- what must hold ---------------------------------------------------------------------------

    def check(self) -> None:
        """Fails if the fleet manager's knowledge is false, or if an invariant is broken."""
        book, desk = self.supervisor.book, self.supervisor.desk
        moving = {one.robot for one in self.bodies.values() if one.by and one.step.load}
        for name, carried in self.carried.items():
            load = desk.load(name)
            if load.state is not LoadState.UNKNOWN and name not in self._forgotten:
                assert carried == load.count and name not in moving, (
                    f'(f) {name} counts as {load}, but carries {carried}')
        if self.load is not None:
            self._check_load(self.load)
        for mission in book.open:
            assert all(one.serial < mission.serial for one in mission.request.after), (
                f'(i) mission {mission.serial} comes after {mission.request.after}')
            load = desk.load(mission.robot)
            assert load.state is LoadState.EMPTY or load.serial in (0, mission.serial), (
                f'(f) {mission.robot} with {load} serves mission {mission.serial}')
            bound = [name for name in self.agvs if desk.load(name).is_bound_to(mission.serial)]
            assert bound in ([], [mission.robot]), (
                f'(f) {bound} carry the load of mission {mission.serial} of {mission.robot}')
            work = desk.work(mission.serial)
            if work is not None and work is not self._known.get(mission.serial):
                self._check_work(mission, self._known.get(mission.serial), work)
                self._known[mission.serial] = work
        queued = [limit.place for limit in self.supervisor.stations.limits.values()
                  if limit.place is not None]
        assert len(queued) == len(set(queued)), f'(h) the queue places: {queued}'

    def _check_load(self, load: LoadType) -> None:
        """(k) No robot is sent onto an edge that is closed to its load."""
        for name, carried in self.carried.items():
            ahead = set(map(abs, self.supervisor.robots[name].record.ahead))
            if carried and name not in self.moved | self._forgotten:
                assert not load.closed & ahead, f'(k) {name} drives {ahead} with its load'

    def _check_work(self, mission: Mission, before: Optional[Work], work: Work) -> None:
        known = {} if before is None else {place: own for place, _, own in before.steps}
        for place, step, own in work.steps:
            was = known.get(place)
            if was is not None and was.state.is_final and was.times_ordered:
                assert own.state is was.state, f'(j) {step.type} was {was.state}, is {own.state}'
            if was is None or own.key in (0, was.key):  # the stops may have been replaced
                continue
            running = [other for at, other, one in work.steps
                       if one.state is StepState.RUNNING and at != place]
            assert not running or StepBlocking.HARD not in [
                one.blocking for one in (step, *running)], f'(e) {step} begins beside {running}'
            assert work.asking is None, f'(e) {step} begins while another one asks'
            self._check_stands(mission, step, work.stops[place.stop].place)
        assert mission.robot or not rules.is_at_work(work), f'(g) no robot is at work: {mission}'
        # A reckless fleet may move a robot during a step whose blocking is NONE.
        if rules.is_at_work(work) and not self.reckless:
            self._check_stands(mission, None, work.stops[work.current].place)

    def _check_sent(self, sent: SendStep) -> None:
        """(g) A robot gets the command for a step only at the place of its work."""
        mission = self.supervisor.book.of_robot(sent.robot)
        work = None if mission is None else self.supervisor.desk.work(mission.serial)
        assert mission is not None and work is not None, f'(e) {sent} is of no mission'
        for place, step, own in work.steps:
            if own.key == sent.command.key and place.stop == work.current:
                self._check_stands(mission, step, work.stops[place.stop].place)

    def _check_stands(self, mission: Mission, step: Optional[WorkStep], place: int) -> None:
        """(g) A robot is at the place of its work."""
        agv = self.agvs[mission.robot]
        if mission.robot in self.moved or step is not None and step.blocking is StepBlocking.NONE:
            return
        places = {place}
        if step is not None and step.when is When.BEFORE_ENTRY:
            places |= {SITE.end_vertex(edge).id for edge in SITE.edges_from(place)}
            places |= ({agv.visited[-1]} if abs(agv.edge) in map(abs, SITE.edges_from(place))
                       else set())
        assert agv.visited[-1] in places and not agv.is_driving, (
            f'(g) {mission.robot} is at {agv}, and not at {place}: {step}')

    def _check_places(self) -> None:
        """(a), (b), (c), (d) and (g) hold for the true places of the robots."""
        inside: Dict[str, List[str]] = {}
        claims = self.supervisor.interlocking.claims
        for name, agv in self.agvs.items():
            is_between = 0.01 < agv.arc < SITE.curve(agv.edge).length - 0.01
            needs = [resource for resource, one in claims.needs.resources.items()
                     if is_between and abs(agv.edge) in one.edges or any(
                         math.dist(agv.position, SITE.vertex(vertex).position)
                         < KIND.radius - ROUNDING for vertex in one.vertices)]
            for resource in needs if name not in self.moved else ():
                inside.setdefault(resource, []).append(name)
                assert resource in claims.stored_of(name), f'(c) {name} does not claim {resource}'
            if not self._is_on_way_into_door(name):
                self._deceived.discard(name)
            elif self.now <= self._failed + FRESH + 1.0:  # the door's report was fresh enough
                self._deceived.add(name)
            if 'gate' in needs and name not in self.moved | self._deceived and not self.lies:
                gate = self.devices['gate']
                assert gate.mode is DeviceMode.OPEN, f'(d) {name} is in the gate: {gate.mode}'
        for resource, names in inside.items():
            assert len(names) <= claims.needs.resources[resource].capacity, (
                f'(b) {names} are at {resource}')
        for identity, body in self.bodies.items():
            if body.by and body.step.blocking is not StepBlocking.NONE and (
                    body.robot not in self.moved):
                at = self.agvs[body.robot].position
                assert self._stood.setdefault(identity, at) == at, (
                    f'(g) {body.robot} moves during {body.step}')

    def _check_final(self, told: PublishStatus) -> None:
        """(j) A mission that has ended does not change its state."""
        status = told.status
        before = self._final.get(status.serial)
        assert before in (None, status.state), f'(j) mission {status.serial} was {before}: {status}'
        if status.serial and not status.state.is_open:
            self._final[status.serial] = status.state
            running = [one for (serial, _), one in self.bodies.items()
                       if one.by and serial == status.serial]
            assert not running, f'(j) mission {status.serial} has ended, but not {running}'


EVENTS = {'beat': 60.0, 'request_mission': 6.0, 'answer': 8.0, 'repair': 4.0, 'combine': 3.0,
          'change': 0.5, 'cancel': 0.4, 'pause': 0.2, 'resume': 1.0, 'steps_fail': 1.5,
          'driver_restarts': 0.3, 'machine_dies': 0.2, 'door_is_silent': 0.2, 'door_restarts': 0.2,
          'door_sticks': 0.1, 'door_fails': 0.1, 'exit_is_removed': 0.1,
          'recklessly_ask': 4.0, 'door_lies': 0.1, 'manager_restarts': 0.3, 'manager_dies': 0.3,
          'robot_is_silent': 0.2, 'robot_stalls': 0.3, 'robot_refuses': 0.1, 'robot_fails': 0.1,
          'robot_forgets': 0.1, 'robot_is_taken_out': 0.1, 'robot_is_moved': 0.2,
          'disk_is_full': 0.1, 'fleet_is_stopped': 0.1, 'station_breaks': 0.1}
"""All events with their weights. Events that continue the work come more often than faults."""
QUIET = {name: EVENTS[name] for name in ('beat', 'request_mission', 'answer', 'repair', 'resume')}
TROUBLE = {name: 1.0 for name in EVENTS if name not in (*QUIET, 'combine')}
TROUBLE.update(manager_restarts=4.0, driver_restarts=3.0, cancel=2.0, change=2.0, answer=2.0,
               beat=2.0)


def _short(change: Any) -> str:
    if isinstance(change, StepAnswer):
        return change.answer.name
    return f'from {change.first_stop}: {[one.place for one in change.stops]}' if change else ''


def _works(world: RandomWork) -> bool:
    return any(one.by for one in world.bodies.values())


def _moves_load(world: RandomWork) -> bool:
    return any(one.by and one.step.load for one in world.bodies.values())


def _asks(world: RandomWork) -> bool:
    return any(one.asks for one in world.supervisor.book.open)


def _is_under_way(world: RandomWork) -> bool:
    """Returns whether a command for a step, or a report of steps, is delayed now."""
    return any(one.subject for one in world._late)


def _has_further_work(world: RandomWork) -> bool:
    """Returns whether a robot that carries out a step must drive to the exit later."""
    serials = {serial for (serial, _), one in world.bodies.items() if one.by}
    return any(one.serial in serials and 16 in one.left[1:] for one in world.supervisor.book.open)


def _may_enter_door(world: RandomWork) -> bool:
    claims = world.supervisor.interlocking.claims
    return any(claims.state(name, 'gate') is ClaimState.READY for name in world.agvs)


def _is_in_queue(world: RandomWork) -> bool:
    return any(limit.is_there for limit in world.supervisor.stations.limits.values())


def _is_loaded(world: RandomWork) -> bool:
    return any(world.carried.values())


def _ends(world: RandomWork) -> bool:
    return any(one.state is MissionState.CANCELLING for one in world.supervisor.book.open)


Moment = Callable[[RandomWork], bool]
MOMENTS: Sequence[Moment] = (_works, _moves_load, _asks, _is_under_way, _may_enter_door,
                             _is_in_queue, _is_loaded, _ends)
"""Rare moments, at which a disturbance finds errors more often."""
COMBINATIONS: Sequence[Tuple[Moment, Tuple[str, ...]]] = (
    (_is_under_way, ('driver_restarts',)), (_is_under_way, ('driver_restarts', 'beat', 'answer')),
    (_is_under_way, ('driver_restarts', 'manager_restarts')),
    (_is_under_way, ('driver_restarts', 'beat', 'manager_restarts')),
    (_works, ('manager_restarts', 'beat', 'manager_restarts')),
    (_works, ('cancel', 'manager_dies')), (_works, ('disk_is_full', 'beat', 'manager_restarts')),
    (_works, ('robot_is_moved',)), (_asks, ('driver_restarts', 'answer')),
    (_asks, ('cancel', 'answer')), (_moves_load, ('driver_restarts', 'cancel')),
    (_is_loaded, ('cancel', 'beat', 'pause')), (_has_further_work, ('exit_is_removed',)),
    (_has_further_work, ('change', 'manager_dies')),
    (_may_enter_door, ('door_fails', 'robot_stalls')),
    (_may_enter_door, ('door_fails', 'fleet_is_stopped')),
    (_may_enter_door, ('manager_restarts', 'door_restarts')),
    (_is_in_queue, ('cancel', 'manager_restarts')), (_ends, ('answer', 'manager_restarts')))
"""Moments and events that are combined on purpose, because they seldom coincide by chance."""


def lived(seed: int, steps: int, load: Optional[LoadType] = None) -> int:
    """Makes one random run. Returns the number of its steps.

    A failure names the seed and the last events. Every third seed makes a reckless run.
    """
    world = RandomWork(seed, seed % 3 == 2, load)
    try:
        world.live(steps)
    except AssertionError as flaw:
        events = '\n'.join(world.history[-60:])
        raise AssertionError(f'life {seed}, step {world.count}: {flaw}\n{world.picture()}\n'
                             f'{events}') from flaw
    finally:
        world.end()
    return world.count
