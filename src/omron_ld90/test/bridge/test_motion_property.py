"""Whoever drives or stops one robot, whatever is lost and restarted meanwhile: nobody's word is
passed by one who does not know of it, and no stop is forgotten."""
from __future__ import annotations

from contextlib import suppress
from typing import Dict, List, NamedTuple, Optional, Tuple

from bridge_builders import yard
from delayed_drive import PERSON, DelayedDrive
from hypothesis import note, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
)
from modelled_controller import Delays

from omron_arcl import ArclError, Execution, Giver
from omron_arcl.motion_authority import AT_ONCE, Cause, Motion, MotionState
from omron_ld90.bridge import events as p

YARD = yard()
SECONDS = st.sampled_from([0.0, 0.05, 0.2, 1.0])
GOALS = st.sampled_from(['3', '4', '5', '6'])
PROGRAMS = ['/adapter', '/joystick']
SETTLED = 20.0  # s in which a robot that can be reached has obeyed, in any dialect


class Word(NamedTuple):
    """What the controller took, or heard that another client had done; `giver` None: that."""

    giver: Optional[Giver]
    drives: bool


class Witness(DelayedDrive):
    """Notes by itself, in order, whose word the controller has taken, and who knew of which."""

    def __init__(self, *arguments: object) -> None:
        self.words: List[Word] = []
        self.words_of_epoch: Dict[int, int] = {}  # so many had been taken when it was told
        self.broken: List[str] = []
        self.lines: List[str] = []  # drives that came to the robot from the controller
        self.persons, self.came = '', False  # last drive, and whether it came to the robot
        self.given_at = -100.0
        self.drives = 0  # that were taken
        self.foreign = False
        super().__init__(*arguments)  # type: ignore[arg-type]
        take = self._controller.give

        def give(command: str, giver: Giver, known_epoch: int, on_end: object) -> Execution:
            drives = command != 'stop'
            known = self.words_of_epoch.get(known_epoch)
            execution = take(command, giver, known_epoch, on_end)  # type: ignore[arg-type]
            if drives and giver == PERSON:
                self.persons, self.came = command, False
            if drives and known_epoch and (
                    known is None or any(word.giver != giver for word in self.words[known:])):
                self.broken.append(f'{giver.name} passed {self.words[known or 0:]}: {command}')
            return execution
        self._controller.give = give  # type: ignore[method-assign]
        self._controller.on_taken = self._on_taken

    def _on_taken(self, giver: Giver, drives: bool) -> None:
        if not (drives and self.words[-1:] == [Word(giver, True)]):  # else it just drives on
            self.words.append(Word(giver, drives))
        self.given_at, self.drives = self.now, self.drives + drives

    def take_cancellation(self, canceller: Giver) -> None:
        """Somebody cancels everything."""
        self.words.append(Word(canceller, False))
        self._controller.cancel([one for one in self._drives if one.result is None], canceller)

    def another_client(self, command: str) -> None:
        """A client of the robot's own server."""
        self.foreign = True
        self.robot.take(command)
        self.foreign = False

    def _on_motion(self, motion: Motion) -> None:
        self.words_of_epoch.setdefault(motion.memory.epoch, len(self.words))
        super()._on_motion(motion)

    def _say(self, line: str) -> None:
        """The word of another client counts once the controller has heard of it."""
        if self.foreign and (line == 'Stopping' or line.startswith('Going to')):
            self.later(self.delays.from_robot, lambda: self._heard(line))
        super()._say(line)

    def _heard(self, line: str) -> None:
        """What comes beside a command of ours with the same effect nobody can tell from it."""
        memory, state = self._controller.motion
        if line == 'Stopping':
            is_clear = self.now > self.given_at + AT_ONCE and state is not MotionState.STOPPING
        else:
            is_clear = line.split()[-1] not in memory.goals
        if self._controller.connected and is_clear:
            self.words.append(Word(None, line != 'Stopping'))

    def _reach_robot(self, line: str) -> None:
        if line == 'oneLineStatus':
            super()._reach_robot(line)
            return
        if line != 'stop':
            self.lines.append(line)
            self.came = self.came or line == self.persons
        elif (self._controller.motion.memory.drives and self.words[-1:] == [Word(PERSON, True)]
                and self.came and self.persons == f'goto {self.robot.goal}'):
            self.broken.append(f'an older stop ended {self.persons} of a person')
        super()._reach_robot(line)


class Robots(RuleBasedStateMachine):
    """One robot, its bridge, its controller, two more programs, a person, and another client."""

    @initialize(strategy=st.sampled_from(['rolling', 'rolling', 'vertex_by_vertex']),
                interruption=st.sampled_from(['name', 'coordinates', 'status', 'nothing']),
                braking=st.sampled_from([0.0, 0.3, 1.5]),
                delays=st.builds(Delays, commands=SECONDS, ends=SECONDS, motions=SECONDS))
    def begin(self, strategy: str, interruption: str, braking: float, delays: Delays) -> None:
        self.world = Witness(YARD, 1, strategy, delays, interruption, braking)
        self.known = dict.fromkeys(PROGRAMS, self.world._controller.motion.memory.epoch)
        self.starts = dict.fromkeys(PROGRAMS, 1)
        self.route_id = 6
        self.last: List[Tuple[Giver, str, int]] = []  # commands of programs, that may come again

    # --- what happens -----------------------------------------------------------------------------

    @rule(seconds=st.sampled_from([0.01, 0.3, 1.0, 4.0]))
    def passes(self, seconds: float) -> None:
        self.world.run(seconds)

    @rule(turn=st.integers(0, 3), length=st.integers(1, 3), knows=st.booleans())
    def order(self, turn: int, length: int, knows: bool) -> None:
        edge, on_it = YARD.nearest_edge(*self.world.robot.position)
        edges = [edge if on_it.fraction < 0.5 else -edge]
        for _ in range(length):
            ways = YARD.edges_from(YARD.end_vertex(edges[-1]).id)
            edges.append(ways[turn % len(ways)])
        self.route_id += 1
        self.world.order(self.route_id, *edges)

    @rule()
    def stop_order(self) -> None:
        self.route_id += 1
        self.world.order(self.route_id)

    @rule(program=st.sampled_from(PROGRAMS))
    def reads(self, program: str) -> None:
        self.known[program] = self.world._controller.motion.memory.epoch

    @rule(program=st.sampled_from(PROGRAMS))
    def program_restarts(self, program: str) -> None:
        """It knows what the one before it knew; what that gave may still come."""
        self.starts[program] += 1

    @rule(program=st.sampled_from(PROGRAMS), goal=GOALS, late=SECONDS)
    def program_drives(self, program: str, goal: str, late: float) -> None:
        self.give(program, f'goto {goal}', late)

    @rule(program=st.sampled_from(PROGRAMS), late=SECONDS)
    def program_stops(self, program: str, late: float) -> None:
        self.give(program, 'stop', late)

    @precondition(lambda self: self.last)
    @rule(which=st.integers(0, 20))
    def comes_again(self, which: int) -> None:
        """A message of before, by a publisher whose connection came back."""
        self.take(*self.last[which % len(self.last)])

    @rule(goal=GOALS)
    def person_drives(self, goal: str) -> None:
        self.take(PERSON, f'goto {goal}', 0)
        self.world.run(0.0)  # so that it is clear which drive it is that comes to the robot

    @rule()
    def person_stops(self) -> None:
        self.take(PERSON, 'stop', 0)

    @rule()
    def person_cancels(self) -> None:
        self.world.take_cancellation(PERSON)

    @rule(command=st.sampled_from(['stop', 'goto 3', 'goto 4']))
    def another_client(self, command: str) -> None:
        self.world.another_client(command)

    @rule(link=st.sampled_from(list(p.Link)), seconds=st.sampled_from([0.1, 1.0, 5.0]))
    def link_breaks(self, link: p.Link, seconds: float) -> None:
        if self.world.up[link]:
            self.world.cut(link, seconds)

    @rule(seconds=st.sampled_from([0.1, 3.0]))
    def bridge_restarts(self, seconds: float) -> None:
        self.world.restart_bridge(seconds)

    @rule()
    def controller_restarts(self) -> None:
        if self.world.up[p.Link.COMMANDS]:
            self.world.restart_controller()

    def give(self, program: str, command: str, late: float) -> None:
        giver, known = Giver(program, str(self.starts[program])), self.known[program]
        self.last.append((giver, command, known))
        self.world.later(late, lambda: self.take(giver, command, known))

    def take(self, giver: Giver, command: str, known_epoch: int) -> None:
        with suppress(ArclError):
            self.world._controller.give(command, giver, known_epoch, lambda result: None)

    # --- what must hold ---------------------------------------------------------------------------

    @invariant()
    def nobody_is_passed(self) -> None:
        if hasattr(self, 'world'):
            assert not self.world.broken

    @invariant()
    def no_drive_is_sent_twice(self) -> None:
        if hasattr(self, 'world'):
            assert len(self.world.lines) <= self.world.drives

    def teardown(self) -> None:
        """In the end every stop is obeyed that nobody's later drive has overtaken."""
        if not hasattr(self, 'world'):
            return
        world = self.world
        world.spared = True
        world.run(SETTLED, lambda: world.is_well)
        world.run(SETTLED)
        note('\n'.join(world.trace))
        note(str(world.words))
        assert not world.broken
        assert not world._controller.motion.memory.stop_owed
        if world.words and not world.words[-1].drives and (
                world._controller.motion.memory.cause is not Cause.OTHER_CLIENT):
            assert world.robot.goal is None, 'the robot drives on'


Robots.TestCase.settings = settings(max_examples=settings.default.max_examples,
                                    stateful_step_count=30)
TestMotion = Robots.TestCase
