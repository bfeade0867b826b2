"""Random stops, with a robot that misbehaves and an adapter that is killed at any step.

The robot refuses, hides its velocity, loses its link, brakes late, and obeys people. Some robots
report whether they stand (a signal in vehicle.yaml). The robot's end of the route protocol is the
real code. These properties always hold:

* after cancelOrder, no route is sent before another order comes;
* cancelOrder and startPause are FINISHED only while the robot stands;
* after a person's stop no route is begun before the master's stopPause or another order;
* during a pause no drive begins before stopPause;
* no two orders have the same number, and each order to drive has an epoch.
"""
from __future__ import annotations

import os

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from vda_builders import DRIVING, STANDING, Lab, RobotSide, lab, say, way

from route_protocol.values import Motion, Reason, ReasonCode
from vda5050_vehicle.drivers.robot_view import RobotPose

VERTICES = sorted(lab().vertices)
BRAKING = 1.2  # s from an accepted stop until the robot stands
REFUSALS = st.sampled_from([
    None, None, ReasonCode.WRONG_CHANGE, ReasonCode.STARTS_ELSEWHERE, ReasonCode.TAKEN_OVER,
    ReasonCode.OTHER])


class Killed(Exception):
    """The adapter is killed here."""


class UnrulyRobot(RobotSide):
    """Answers as the bridge does, but not always."""

    def __init__(self):
        super().__init__()
        self.braking = 0.0  # s until the robot stands
        self.by_hand = False  # True: a person drives the robot

    def arrive(self, order):
        if self.answers and not order.edges:
            self.braking = BRAKING if self.moves else 0.0
            self.by_hand = False
        super().arrive(order)

    @property
    def motion(self):
        """The motion that the robot reports."""
        if self.by_hand:
            return Motion.MOVED
        return Motion.COMING_TO_REST if self.braking > 0.0 else super().motion

    @property
    def moves(self):
        """Whether the robot really moves."""
        return self.drives or self.braking > 0.0 or self.by_hand


class UnrulyLab(Lab):
    """The laboratory with an unruly robot; the adapter can be killed between two effects."""

    hides = tells_standing = False
    effects_left = None

    def __init__(self):
        super().__init__()
        self.robot = UnrulyRobot()

    def look(self):
        """Gives the vehicle those values of the robot's state that the robot reports."""
        moves = self.robot.moves
        velocity = DRIVING if moves else STANDING
        if self.robot.answers:
            self.see(velocity=None if self.hides else velocity,
                     standing=not moves if self.tells_standing else None)

    def do(self, effects):
        for effect in effects:
            if self.effects_left is not None:
                if self.effects_left == 0:
                    raise Killed
                self.effects_left -= 1
            super().do([effect])

    def step(self):
        """Runs for a tenth of a second."""
        self.now += 0.1
        self.robot.braking = max(self.robot.braking - 0.1, 0.0)
        if self.robot.answers:
            self.driver.on_report(self.robot.report(), self.now)
        self.do(self.vehicle.tick(self.now))
        self.look()


class RandomStops(RuleBasedStateMachine):
    """One run."""

    @initialize(data=st.data(), base=st.integers(3, 5), tells_standing=st.booleans())
    def begin(self, data, base, tells_standing):
        self.lab = UnrulyLab()
        self.lab.tells_standing = tells_standing
        self.lab.look()
        self.names = 0
        self.cancelled_at = None  # number of commands sent when the cancel was accepted
        self.paused_at = None
        self.overruled = None  # the epochs since a person's act
        self.moved_at = None  # number of commands sent when a person moved the waiting robot
        self.known = {}  # status of each stop
        self.stops = []
        self.order(data, base, False)
        self.wait(1)

    def name(self):
        self.names += 1
        return f'i{self.names}'

    def here(self):
        return int(self.lab.vehicle.state.order.last_node[0] or 8)

    def attempt(self, call):
        """Carries out an act; if the adapter is killed during the act, it restarts from its
        journal.
        """
        try:
            call()
        except Killed:
            self.lab.effects_left = None
            self.restart()

    def restart(self):
        self.lab.effects_left = None
        self.lab = self.lab.restarted()
        self.lab.look()

    # --- the master -------------------------------------------------------------------------------

    @precondition(lambda self: not self.lab.vehicle.state.busy)
    @rule(data=st.data(), base=st.integers(2, 4), acts=st.booleans())
    def order(self, data, base, acts):
        goal = data.draw(st.sampled_from([v for v in VERTICES if v != self.here()]))
        track = way(self.here(), goal)
        track = track.part(0, min(len(track.stops) - 1, 5))
        name = self.name()
        actions = {track.stops[1].node_id: [say(f'a{name}', 'HARD')]} if acts else None
        sent = len(self.lab.robot.routes)
        self.attempt(lambda: self.lab.order(track.order(
            name, base=min(base, len(track.stops)), start_deviation=30.0, actions=actions)))
        if self.lab.vehicle.state.order.order_id == name:
            self.cancelled_at = self.overruled = self.moved_at = None
            self.paused_at = None if self.paused_at is None else sent

    @rule()
    def update(self):
        order = self.lab.vehicle.state.order
        if order.order_id and not order.cancelled and order.nodes:
            node, sequence = order.decision_point
            following = lab().end_vertex(lab().edges_from(int(node))[0]).id
            self.attempt(lambda: self.lab.order(way(int(node), following).order(
                order.order_id, order.order_update_id + 1, first_sequence=sequence)))

    @rule()
    def cancel(self):
        sent, name = len(self.lab.robot.routes), self.name()
        was_busy = self.lab.vehicle.state.busy
        self.attempt(lambda: self.lab.act('cancelOrder', name))
        if was_busy and name in self.lab.vehicle.state.actions:
            self.stops.append(name)
            self.cancelled_at = sent if self.cancelled_at is None else self.cancelled_at

    @rule()
    def pause(self):
        sent, name = len(self.lab.robot.routes), self.name()
        self.attempt(lambda: self.lab.act('startPause', name))
        if self.lab.vehicle.state.paused:
            self.stops.append(name)
            self.paused_at = sent if self.paused_at is None else self.paused_at

    @rule()
    def resume(self):
        self.attempt(lambda: self.lab.act('stopPause', self.name()))
        if not self.lab.vehicle.state.paused:
            self.paused_at = None
        if not self.lab.vehicle.state.held:
            self.overruled = self.moved_at = None

    # --- the robot --------------------------------------------------------------------------------

    @rule(steps=st.sampled_from([1, 5, 15, 40]))
    def wait(self, steps):
        for _ in range(steps):
            self.attempt(self.lab.step)
            self.a_stop_is_finished_while_the_robot_stands()

    @precondition(lambda self: self.lab.robot.drives)
    @rule(edges=st.integers(1, 3))
    def drive(self, edges):
        robot = self.lab.robot
        robot.done = min(robot.done + edges, len(robot.route))
        x, y = lab().end_vertex(robot.route[robot.done - 1]).position
        self.attempt(lambda: self.lab.see(pose=RobotPose(x, y, 0.0)))
        self.wait(1)

    @rule(code=REFUSALS)
    def refuse(self, code):
        self.lab.robot.refuses = None if code is None else Reason(code, 'refused')

    @rule()
    def hide(self):
        self.lab.hides = not self.lab.hides

    @rule()
    def link(self):
        self.lab.robot.answers = not self.lab.robot.answers

    @precondition(lambda self: self.lab.robot.drives)
    @rule(drives_on=st.booleans())
    def a_person_stops_it(self, drives_on):
        """A person stops the robot, and perhaps drives it to another place."""
        robot = self.lab.robot
        robot.by_hand = drives_on
        robot.braking = BRAKING
        robot.overruled()
        if self.lab.vehicle.state.busy:
            self.overruled = {*(self.overruled or ()), robot.vehicle.state.epoch}

    @precondition(lambda self: self.lab.robot.drives)
    @rule(drives_on=st.booleans())
    def a_person_stops_it_while_the_base_grows(self, drives_on):
        """The longer route was ordered before the adapter knew of the stop."""
        self.a_person_stops_it(drives_on)
        self.update()
        self.wait(1)

    @precondition(lambda self: self.lab.robot.answers and not self.lab.vehicle.state.busy)
    @rule(data=st.data())
    def a_person_moves_it_between_two_drives(self, data):
        """A person moves the robot during an action of a node; the action ends afterwards."""
        self.lab.robot.refuses = None
        self.order(data, 4, True)
        self.wait(5)
        if self.lab.robot.drives:
            self.drive(1)
        self.wait(5)
        robot, state = self.lab.robot, self.lab.vehicle.state
        robot.overruled()
        if state.busy and state.drive.at_rest:
            self.moved_at = len(robot.routes)
        self.attempt(self.lab.step)
        for name in self.lab.started:
            self.attempt(lambda: self.lab.end_action(name))  # noqa: B023
        self.wait(5)

    @precondition(lambda self: self.lab.robot.by_hand)
    @rule()
    def the_person_lets_go(self):
        self.lab.robot.by_hand = False

    @precondition(lambda self: self.lab.started)
    @rule(data=st.data())
    def an_action_ends(self, data):
        name = data.draw(st.sampled_from(self.lab.started))
        self.attempt(lambda: self.lab.end_action(name))

    # --- the adapter ------------------------------------------------------------------------------

    @rule(after=st.integers(0, 3))
    def it_will_be_killed(self, after):
        self.lab.effects_left = after

    @rule()
    def it_is_killed(self):
        self.restart()

    # --- invariants -------------------------------------------------------------------------------

    @invariant()
    def no_route_after_a_cancel(self):
        if hasattr(self, 'lab') and self.cancelled_at is not None:
            later = self.lab.robot.routes[self.cancelled_at:]
            assert not [command for command in later if command.edges], later

    @invariant()
    def no_route_is_sent_while_paused(self):
        if hasattr(self, 'lab') and self.paused_at is not None:
            later = self.lab.robot.routes[self.paused_at:]
            assert not [command for command in later if command.edges], later

    @invariant()
    def no_route_is_begun_after_a_persons_stop(self):
        if hasattr(self, 'lab') and self.overruled is not None:
            assert not [order for order in self.lab.robot.routes if order.epoch in self.overruled]
            assert not self.lab.robot.drives

    @invariant()
    def no_route_gets_longer_after_a_person_moved_the_robot_that_waited(self):
        if hasattr(self, 'lab') and self.moved_at is not None:
            later = self.lab.robot.routes[self.moved_at:]
            assert not [command for command in later if command.edges], later

    @invariant()
    def each_order_has_a_number_of_its_own(self):
        if hasattr(self, 'lab'):
            sent = self.lab.robot.routes
            assert all(order.epoch for order in sent if order.edges)
            assert len({order.number for order in sent}) == len(set(sent))

    @invariant()
    def a_stop_is_finished_while_the_robot_stands(self):
        if not hasattr(self, 'lab'):
            return
        for name in self.stops:
            status = self.lab.status(name) if self.lab.states else None
            if status == 'FINISHED' and self.known.get(name) != status:
                assert not self.lab.robot.moves, name
            self.known[name] = status


RandomStops.TestCase.settings = settings(
    max_examples=(2000 if os.environ.get('LD90_LONG_TESTS')
                  else settings.default.max_examples),
    stateful_step_count=40,
    deadline=None)
TestRandomStops = RandomStops.TestCase
