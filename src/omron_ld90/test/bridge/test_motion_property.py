"""Many givers drive and stop one robot; messages are lost, and programs are restarted.

No giver drives the robot without knowledge of an earlier command, and no stop is forgotten.
"""
from __future__ import annotations

import os
from contextlib import suppress
from typing import List, Sequence, Tuple

from delayed_drive import PERSON
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
from motion_witness import YARD, Witness
from simulated_robot import DIALECTS

from omron_arcl import ArclError, Giver
from omron_arcl.commands import ACKNOWLEDGE_TIMEOUT
from omron_arcl.records import MotionCause
from omron_ld90.bridge import events as p

SECONDS = st.sampled_from([0.0, 0.05, 0.2, 1.0])
DELAYS = st.builds(Delays, commands=SECONDS, ends=SECONDS, motions=SECONDS,
                   to_robot=st.sampled_from([0.0, 0.2]))
STRATEGIES = st.sampled_from(['rolling', 'rolling', 'vertex_by_vertex'])
GOALS = st.sampled_from(['3', '4', '5', '6'])
COMMANDS = ['stop', 'goto 3', 'goto 4']  # commands of another client
WITHOUT_A_GOAL = ['gotoPoint 3000 3000 0', 'dock', 'undock']  # commands of another client
PROGRAMS = ['/adapter', '/joystick']
IN_AN_OUTAGE = [('person_stops',), ('person_cancels',), *((program,) for program in PROGRAMS),
                *(('another_client', command) for command in COMMANDS)]
UNANSWERED = ACKNOWLEDGE_TIMEOUT + 1.0  # s after which an unanswered drive has timed out
SETTLED = 20.0  # s until a robot that can be reached has obeyed its commands, in any dialect


class Robots(RuleBasedStateMachine):
    """One robot, its bridge, its controller, two more programs, a person, and another client."""

    world: Witness

    @initialize(strategy=STRATEGIES,
                interruption=st.sampled_from(['name', 'coordinates', 'status', 'nothing']),
                braking=st.sampled_from([0.0, 0.3, 1.5]), delays=DELAYS)
    def begin(self, strategy: str, interruption: str, braking: float, delays: Delays) -> None:
        self.start(Witness(strategy, delays, interruption, braking))

    def start(self, world: Witness) -> None:
        """Starts everything."""
        self.world = world
        self.known = dict.fromkeys(PROGRAMS, self.world._controller.motion.memory.epoch)
        self.starts = dict.fromkeys(PROGRAMS, 1)
        self.route_id = 6
        self.last: List[Tuple[Giver, str, int]] = []  # commands of programs; each may arrive again

    # --- events -----------------------------------------------------------------------------------

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
        """Restarts a program. The new process knows what the old one knew. Commands of the old
        process may still arrive.
        """
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
        """Lets an old message arrive again, because the connection of its publisher came back."""
        self.take(*self.last[which % len(self.last)])

    @rule(goal=GOALS)
    def person_drives(self, goal: str) -> None:
        self.take(PERSON, f'goto {goal}', 0)
        self.world.run(0.0)  # earlier drives arrive first, so that no two drives cross

    @rule()
    def person_stops(self) -> None:
        self.take(PERSON, 'stop', 0)

    @rule()
    def person_cancels(self) -> None:
        self.world.take_cancellation(PERSON)

    @precondition(lambda self: self.world.open_drives)
    @rule(which=st.integers(0, 2))
    def giver_cancels_its_drive(self, which: int) -> None:
        drives = self.world.open_drives
        self.world.cancel_own(drives[which % len(drives)])

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS])
    @rule(seconds=st.sampled_from([0.1, 1.0]))
    def drive_that_replaces_a_cancelled_one_is_lost(self, seconds: float) -> None:
        self.person_drives('6')
        self.world.run(1.0)
        self.world.stall(3.0)
        self.person_drives('3')
        for drive in self.world.open_drives[-2:-1]:
            self.world.cancel_own(drive)
        self.world.cut(p.RobotLink.COMMANDS, seconds)
        self.world.run(seconds + 6.0)

    @rule(command=st.sampled_from(COMMANDS))
    def another_client(self, command: str) -> None:
        self.world.another_client(command)

    @rule(command=st.sampled_from(COMMANDS), seconds=st.sampled_from([0.5, 3.0]))
    def another_client_is_heard_in_parts(self, command: str, seconds: float) -> None:
        self.world.another_client(command, stalls=seconds)

    @rule(link=st.sampled_from(list(p.RobotLink)), seconds=st.sampled_from([0.1, 1.0, 5.0]))
    def link_breaks(self, link: p.RobotLink, seconds: float) -> None:
        if self.world.up[link]:
            self.world.cut(link, seconds)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS]
                  and self.world.robot.goal is not None)
    @rule(seconds=st.sampled_from([0.1, 1.0]))
    def stop_of_a_person_is_lost(self, seconds: float) -> None:
        self.person_stops()
        self.world.cut(p.RobotLink.COMMANDS, seconds)
        self.world.run(seconds + 1.0)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS])
    @rule(seconds=st.sampled_from([0.5, 3.0]))
    def link_stalls(self, seconds: float) -> None:
        self.world.stall(seconds)

    @rule(seconds=st.sampled_from([0.3, 1.5, 4.0]))
    def motions_are_lost(self, seconds: float) -> None:
        """Loses messages of `motion`. After that the bridge hears only the newest one."""
        self.world.lose_motions(seconds)

    @precondition(lambda self: self.world.is_well and self.world._controller.connected)
    @rule(act=st.sampled_from(IN_AN_OUTAGE))
    def epoch_of_others_is_replaced_by_one_of_the_bridge(self, act: Sequence[str]) -> None:
        """Lets the bridge stop the robot for another reason before it hears of an act of others."""
        self.order(0, 2, True)
        self.world.run(1.5)
        self.world.lose_motions(7.0)
        doer, *command = act
        if doer in PROGRAMS:
            self.reads(doer)
            self.give(doer, 'stop', 0.0)
        else:
            getattr(self, doer)(*command)
        self.world.cut(p.RobotLink.OUTGOING, 6.0)  # the route fails
        self.world.run(8.0)
        self.order(1, 2, True)
        self.world.run(1.0)

    @rule(seconds=st.sampled_from([0.1, 3.0]))
    def bridge_restarts(self, seconds: float) -> None:
        self.world.restart_bridge(seconds)

    @rule(seconds=st.sampled_from([0.0, 4.0]))
    def controller_restarts(self, seconds: float) -> None:
        if self.world.up[p.RobotLink.COMMANDS]:
            self.world.restart_controller(seconds)

    @precondition(lambda self: self.world.is_well)
    @rule(goal=GOALS, link=st.sampled_from(list(p.RobotLink)))
    def person_drives_as_a_route_fails(self, goal: str, link: p.RobotLink) -> None:
        """Lets a person drive while the stop for a failed route of the bridge is on its way."""
        if not self.world.bridge.running:
            self.order(0, 2, True)
            self.world.run(1.0)
        self.world.cut(link, 5.0)
        self.world.run(6.0, lambda: self.world.has_ended and self.world._controller.connected)
        self.person_drives(goal)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS]
                  and not self.world._controller.is_stalled)
    @rule(program=st.sampled_from(PROGRAMS), goal=GOALS, command=st.sampled_from(COMMANDS))
    def program_drives_before_the_robot_has_said_why_it_broke_off(
            self, program: str, goal: str, command: str) -> None:
        """Lets another client break off a drive. The link holds back all lines after the first."""
        self.reads(program)
        self.give(program, f'goto {goal}', 0.0)
        self.world.run(1.0)
        self.another_client_is_heard_in_parts(command, 2.0)
        self.world.run(0.3)
        self.reads(program)
        self.give(program, f'goto {goal}', 0.0)
        # A command that comes sooner could not be told apart from these commands.
        self.world.run(3.0)

    @precondition(lambda self: self.world.is_well and not self.world._controller.is_stalled)
    @rule(turn=st.integers(0, 3), command=st.sampled_from(COMMANDS))
    def order_comes_before_the_robot_has_said_why_it_broke_off(
            self, turn: int, command: str) -> None:
        """Lets another client break off a route. An order comes before the lines that say why."""
        self.order(turn, 2, True)
        self.world.run(1.5)
        self.another_client_is_heard_in_parts(command, 2.0)
        self.world.run(0.3)
        self.order(turn, 2, True)
        self.world.run(3.0)

    @precondition(lambda self: self.world.is_well and self.world.bridge.running)
    @rule(link=st.sampled_from(list(p.RobotLink)))
    def route_fails_without_a_controller(self, link: p.RobotLink) -> None:
        """Lets a route fail while there is no controller, so that the bridge's first stop fails."""
        self.world.restart_controller(9.0)
        self.world.cut(link, 5.0)
        self.world.run(8.0, lambda: self.world.has_ended)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS])
    @rule(act=st.sampled_from(IN_AN_OUTAGE), goal=GOALS, restarts=st.booleans())
    def somebody_acts_in_an_outage(self, act: Sequence[str], goal: str, restarts: bool) -> None:
        """Lets a giver or client act in an outage, or just before a restart of the controller.

        Then a program that does not know of this act drives the robot. Program and other client use
        different goals, because otherwise their drives could not be told apart.
        """
        program, (doer, *command) = PROGRAMS[0], act
        goals = [one for one in (str((int(goal) + k) % 4 + 3) for k in range(4))
                 if command != [f'goto {one}']]
        for goal in goals[:2]:  # two goals: the robot may be at the first one already
            self.reads(program)
            self.give(program, f'goto {goal}', 0.0)
            self.world.run(1.0)
        goal = goals[2]
        self.reads(program)
        if not restarts:
            self.world.cut(p.RobotLink.COMMANDS, 1.0)
        if doer in PROGRAMS:
            self.give(doer, 'stop', 0.0)
        else:
            getattr(self, doer)(*command)
        if restarts:
            self.controller_restarts(0.0)
        self.world.run(6.5)  # after this time the robot must have obeyed each stop
        self.give(program, f'goto {goal}', 0.0)

    def help(self) -> None:
        """Enables the robot to drive again, as a person would."""

    def give(self, program: str, command: str, late: float) -> None:
        giver, known = Giver(program, str(self.starts[program])), self.known[program]
        self.last.append((giver, command, known))
        self.world.later(late, lambda: self.take(giver, command, known))

    def take(self, giver: Giver, command: str, known_epoch: int) -> None:
        if not self.world.is_heard:
            return
        with suppress(ArclError):
            self.world._controller.give(command, giver, known_epoch, lambda result: None)

    # --- invariants -------------------------------------------------------------------------------

    @invariant()
    def nobody_is_passed(self) -> None:
        if hasattr(self, 'world'):
            assert not self.world.broken, self.world.broken

    @invariant()
    def no_drive_is_sent_twice(self) -> None:
        if hasattr(self, 'world'):
            assert len(self.world.lines) <= self.world.drives

    def teardown(self) -> None:
        if hasattr(self, 'world'):
            self.settle()
            note('\n'.join(self.world.trace))
            note(str(self.world.words))
            self.check_end()

    def settle(self) -> None:
        """Lets nothing fail any more, and makes the robot able to drive."""
        self.world.spared = True
        self.help()
        self.world.run(SETTLED, lambda: self.world.is_well)
        self.world.run(SETTLED)
        if self.world.owed_stop_waits:
            self.world.run(UNANSWERED)

    def check_end(self) -> None:
        """Checks that at the end the robot obeys each stop that no later drive has replaced."""
        world = self.world
        assert not world.broken, world.broken
        memory = world._controller.motion.memory
        assert not memory.stop_owed
        assert not (world.bridge.running and world.bridge.robot.tracker.awaits_motion), (
            'the bridge waits for ever to hear what became of its drive')
        if world.robot.goal is not None and not world._anothers:
            assert memory.giver.name, f'the robot drives to {world.robot.goal} without an owner'
        last = world._last_word()
        docks_for_others = world._anothers and memory.cause is MotionCause.ROBOT
        if last and not last.drives and not (
                docks_for_others or memory.cause is MotionCause.OTHER_CLIENT):
            assert world.robot.goal is None, 'the robot drives on'


class SimulatedRobots(Robots):
    """The same search with the simulated LD-90 in every dialect, and with emergency stops."""

    @initialize(strategy=STRATEGIES, dialect=st.sampled_from(DIALECTS), delays=DELAYS)
    def begin(self, strategy: str, dialect: str, delays: Delays) -> None:
        self.start(Witness(strategy, delays, dialect=dialect))

    @rule(program=st.sampled_from(PROGRAMS), late=SECONDS)
    def program_gives_what_the_robot_refuses(self, program: str, late: float) -> None:
        self.give(program, 'goto 99', late)

    @rule(command=st.sampled_from(WITHOUT_A_GOAL))
    def another_client_drives_without_a_goal(self, command: str) -> None:
        self.world.another_client(command)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS])
    @rule(act=st.sampled_from(
        [*IN_AN_OUTAGE, *(('another_client', one) for one in WITHOUT_A_GOAL)]), goal=GOALS,
        restarts=st.booleans())
    def somebody_acts_in_an_outage(self, act: Sequence[str], goal: str, restarts: bool) -> None:
        super().somebody_acts_in_an_outage(act, goal, restarts)

    @precondition(lambda self: self.world.up[p.RobotLink.COMMANDS])
    @rule(seconds=st.sampled_from([0.3, 1.0]))
    def robot_leaves_its_dock_for_a_cancelled_drive(self, seconds: float) -> None:
        """Lets the robot undock for a drive that is cancelled; the newer drive is lost."""
        self.take(PERSON, 'dock', 0)
        self.world.run(25.0, lambda: self.world.robot.status.startswith('DockingState: Docked'))
        self.person_drives('6')
        self.world.run(seconds)
        self.world.stall(0.5)
        self.person_drives('3')
        for drive in self.world.open_drives[-2:-1]:
            self.world.cancel_own(drive)
        self.world.cut(p.RobotLink.COMMANDS, 0.1)
        self.world.run(6.1)

    @precondition(lambda self: not self.world.robot.is_stopped_by_button)
    @rule()
    def emergency_stop(self) -> None:
        self.world.is_alone = False
        self.world.robot.inject('estop press')

    @rule()
    def help(self) -> None:
        self.world.is_alone = False
        self.world.robot.inject('estop release')
        self.world.robot.hear_another('enableMotors')


IS_LONG = os.environ.get('LD90_LONG_TESTS') == '1'  # 20,000 examples together
Robots.TestCase.settings = settings(
    max_examples=8_000 if IS_LONG else settings.default.max_examples // 5, stateful_step_count=30)
SimulatedRobots.TestCase.settings = settings(
    max_examples=12_000 if IS_LONG else settings.default.max_examples // 3, stateful_step_count=30)
TestMotion = Robots.TestCase
TestMotionOfTheSimulator = SimulatedRobots.TestCase
