"""Random masters, random robots, random losses: properties that must always hold.

The vehicle of the laboratory gets orders, updates, cancellations and pauses; messages are repeated,
reordered or lost. Its robot drives, fails and is stopped, and the adapter is killed. The strict
checker checks each state that the vehicle sends (`Lab.do`). In addition:

* a route never contains an edge that was not released;
* a rejected order, or a copy of an accepted order, changes nothing except the errors;
* every action is started at most once, and at its node if the vehicle must stand for it;
* an ended action keeps its result, and an action that ran when the adapter was killed has ended.
"""
from __future__ import annotations

import json
import os
from collections import Counter
from itertools import takewhile

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from vda_builders import DRIVING, STANDING, Lab, lab, say, way

from vda5050_protocol.action_queue import Scope
from vda5050_protocol.values import EmergencyStop
from vda5050_vehicle.core import journal

VERTICES = sorted(lab().vertices)
BLOCKING = st.sampled_from(['NONE', 'SOFT', 'HARD'])


class RandomMaster(RuleBasedStateMachine):
    """One run."""

    def __init__(self):
        super().__init__()
        self.released = set()      # (order id, sequence id of the edge, signed edge)
        self.sent = []  # accepted orders, and their messages
        self.started = Counter()
        self.ended = {}  # for each id of an ended action, its entry in the state
        self.actions = 0

    @initialize()
    def begin(self):
        self.lab = Lab(at=8)

    # --- the master -------------------------------------------------------------------------------

    def act_on(self, track, data):
        """Puts actions on some of the nodes and edges."""
        found = {}
        nodes = [stop.node_id for stop in track.stops]
        for name in [*nodes, *(edge for edge in track.edges if edge not in nodes)]:
            if name not in found and data.draw(st.integers(0, 2)) == 0:
                self.actions += 1
                found[name] = [say(f'a{self.actions}', data.draw(BLOCKING))]
        return found

    def send(self, order):
        """Sends an order, and checks the result."""
        before = self.lab.order_record
        message = self.lab.order(order)
        taken = (self.lab.state['orderId'], self.lab.state['orderUpdateId']) == (
            order['orderId'], order['orderUpdateId']) and self.lab.order_record != before
        if taken:
            self.sent.append((order, message))
            for edge in order['edges']:
                if edge['released']:
                    self.released.add((order['orderId'], edge['sequenceId'], int(edge['edgeId'])))
        else:
            self.nothing_has_changed(before)

    def nothing_has_changed(self, before):
        """Checks that only reports of the robot have changed what the vehicle knows."""
        assert self.lab.order_record == before

    def here(self):
        """Returns the last node that the vehicle has passed, as the master knows it."""
        return int(self.lab.vehicle.state.order.last_node[0] or 8)

    @rule(data=st.data(), number=st.integers(0, 3), update=st.sampled_from([0, 5]))
    def new_order(self, data, number, update):
        goal = data.draw(st.sampled_from([v for v in VERTICES if v != self.here()]))
        track = way(self.here(), goal)
        track = track.part(0, min(len(track.stops) - 1, data.draw(st.integers(1, 5))))
        base = data.draw(st.integers(1, len(track.stops)))
        self.send(track.order(f'order {number}', update, base,
                              start_deviation=data.draw(st.sampled_from([0.0, 30.0])),
                              actions=self.act_on(track, data)))

    @rule(data=st.data(), ahead=st.integers(-1, 2), shift=st.sampled_from([0, 0, 0, 2]))
    def update(self, data, ahead, shift):
        order = self.lab.vehicle.state.order
        if not order.order_id:
            return
        node, sequence = order.decision_point
        goal = data.draw(st.sampled_from([v for v in VERTICES if str(v) != node]))
        track = way(int(node), goal)
        track = track.part(0, min(len(track.stops) - 1, data.draw(st.integers(1, 4))))
        base = data.draw(st.integers(1, len(track.stops)))
        update = max(order.order_update_id + ahead, 0)
        self.send(track.order(order.order_id, update, base, first_sequence=sequence + shift,
                              actions=self.act_on(track, data)))

    @precondition(lambda self: self.sent)
    @rule(data=st.data(), late=st.booleans())
    def a_copy_of_a_message_comes(self, data, late):
        if late:
            self.a_master_that_sets_things_right(data)
            self.drive_and_act_to_the_end()
        before = self.lab.order_record
        self.lab.receive_order(data.draw(st.sampled_from(self.sent))[1])
        self.nothing_has_changed(before)

    @precondition(lambda self: self.sent)
    @rule(data=st.data())
    def an_order_is_sent_anew(self, data):
        """Sends an earlier order with new actionIds, as a master does that wants to repeat it."""
        order = json.loads(json.dumps(data.draw(st.sampled_from(self.sent))[0]))
        for action in (found for element in (*order['nodes'], *order['edges'])
                       for found in element['actions']):
            self.actions += 1
            action['actionId'] = f'a{self.actions}'
        self.send(order)

    @rule(kind=st.sampled_from(['cancelOrder', 'startPause', 'stopPause', 'stateRequest']))
    def instant(self, kind):
        self.actions += 1
        action_id = self.lab.act(kind, f'i{self.actions}')
        if kind in ('startPause', 'cancelOrder'):
            self.wait(1.5)
        if kind == 'cancelOrder' and self.lab.status(action_id) == 'FINISHED':
            assert self.lab.nodes == [], 'a cancelled order still exists'

    @rule(blocking=BLOCKING)
    def instant_say(self, blocking):
        self.actions += 1
        self.lab.act('say', f'i{self.actions}', blocking, text='hello')

    @rule(noise=st.binary(max_size=20))
    def noise(self, noise):
        self.lab.do(self.lab.vehicle.receive([('order', noise)], self.lab.now))

    @rule(data=st.data())
    def a_master_that_sets_things_right(self, data):
        """Cancels the order, and then sends an order that can be driven."""
        self.emergency_stop(False)
        self.lose(False)
        self.instant('stopPause')
        if self.lab.vehicle.state.busy:
            self.instant('cancelOrder')
            self.wait(1.5)
            self.finish_actions()
        goal = data.draw(st.sampled_from([v for v in VERTICES if v != self.here()]))
        track = way(self.here(), goal)
        self.actions += 1
        self.send(track.order(f'mission {self.actions}', start_deviation=30.0,
                              actions=self.act_on(track, data)))

    @rule()
    def drive_and_act_to_the_end(self):
        for _ in range(20):
            self.wait(0.1)
            if self.lab.robot.drives:
                self.lab.drive(1)
                self.the_vehicle_stands_where_an_action_needs_it()
            else:
                self.finish_actions()

    def finish_actions(self):
        for entry in self.lab.vehicle.state.actions:
            if entry.is_active and entry.action.action_type == 'say':
                self.lab.end_action(entry.action.action_id)

    # --- the robot --------------------------------------------------------------------------------

    @precondition(lambda self: self.lab.robot.drives)
    @rule(edges=st.integers(1, 5))
    def drive(self, edges):
        left = len(self.lab.robot.route) - self.lab.robot.done
        self.lab.drive(min(edges, left))

    @precondition(lambda self: self.lab.robot.drives)
    @rule()
    def fail(self):
        self.lab.robot.fail('no progress')
        self.lab.see(velocity=STANDING)
        self.lab.wait(0.1)

    @rule(seconds=st.sampled_from([0.1, 1.5, 6.0]))
    def wait(self, seconds):
        self.lab.see(velocity=DRIVING if self.lab.robot.drives else STANDING)
        self.lab.wait(seconds)
        if seconds > 1.0 and self.lab.robot.answers and self.lab.vehicle.state.held:
            assert not self.lab.robot.drives, (
                'the vehicle drives although it is paused or has failed')

    @rule(pressed=st.booleans())
    def emergency_stop(self, pressed):
        self.lab.see(e_stop=EmergencyStop.MANUAL if pressed else EmergencyStop.NONE)

    @rule(lost=st.booleans())
    def lose(self, lost):
        self.lab.robot.answers = not lost

    @precondition(lambda self: self.lab.started)
    @rule(data=st.data(), succeeded=st.booleans())
    def an_action_ends(self, data, succeeded):
        """Ends an action that may have started long ago: the end is reported late, or twice."""
        self.lab.end_action(data.draw(st.sampled_from(self.lab.started)), succeeded)

    @rule()
    def the_adapter_is_killed(self):
        if self.lab.journal:
            self.started.update(self.lab.started)
            self.lab = self.lab.restarted()

    # --- invariants -------------------------------------------------------------------------------

    @invariant()
    def nothing_unreleased_is_driven(self):
        """Allows one exception: the robot may drive back to the first node over a driven edge.

        This happens if the robot is away from this node, but within the node's allowed deviation.
        """
        if not hasattr(self, 'lab'):
            return
        allowed = {edge for _, _, edge in self.released}
        for command in self.lab.robot.routes:
            approach = tuple(takewhile(lambda edge: edge not in allowed, command.edges))
            assert {-edge for edge in approach} <= allowed, (command, allowed)
            assert set(command.edges[len(approach):]) <= allowed, (command, allowed)

    @invariant()
    def the_journal_is_the_state(self):
        if hasattr(self, 'lab') and self.lab.journal:
            state = self.lab.vehicle.state
            assert journal.read(self.lab.journal, type(state.drive)) == state

    @invariant()
    def the_vehicle_stands_where_an_action_needs_it(self):
        if not hasattr(self, 'lab'):
            return
        vehicle = self.lab.vehicle
        for entry in vehicle.state.actions:
            if entry.is_active and entry.forbids_driving and entry.scope is Scope.NODE:
                assert entry.sequence_id == vehicle.state.order.last_node[1], entry

    @invariant()
    def nothing_runs_beside_what_runs_alone(self):
        if hasattr(self, 'lab'):
            active = [entry for entry in self.lab.vehicle.state.actions
                      if entry.is_active and entry.action.action_type == 'say']
            assert len(active) <= 1 or not any(
                entry.action.blocking_type.forbids_others for entry in active), active

    @invariant()
    def no_action_comes_before_its_turn(self):
        if not hasattr(self, 'lab'):
            return
        reached = self.lab.vehicle.state.order.last_node[1]
        for entry in self.lab.vehicle.state.actions:
            if entry.triggered and entry.belongs_to_order:
                assert entry.sequence_id <= reached + (entry.scope is Scope.EDGE), entry

    @invariant()
    def what_waits_is_an_action_of_what_is_left(self):
        """Actions of a horizon that was replaced are removed."""
        if not hasattr(self, 'lab'):
            return
        order = self.lab.vehicle.state.order
        left = {(element.sequence_id, action.action_id)
                for element in (*order.nodes, *order.edges) for action in element.actions}
        for entry in self.lab.vehicle.state.actions:
            if entry.belongs_to_order and not entry.triggered and not entry.status.has_ended:
                assert (entry.sequence_id, entry.action.action_id) in left, entry

    @invariant()
    def what_runs_was_started(self):
        """Checks that the present adapter started each running action, not one that was killed."""
        if hasattr(self, 'lab'):
            for entry in self.lab.vehicle.state.actions:
                if entry.is_active and entry.action.action_type == 'say':
                    assert entry.action.action_id in self.lab.started, entry

    @invariant()
    def what_has_ended_stays_as_it_ended(self):
        if not hasattr(self, 'lab'):
            return
        for entry in self.lab.vehicle.state.actions:
            if entry.status.has_ended:
                ended = self.ended.setdefault(entry.action.action_id, entry)
                assert (ended.status, ended.result) == (entry.status, entry.result), ended

    @invariant()
    def every_action_is_started_once(self):
        if hasattr(self, 'lab'):
            once = self.started + Counter(self.lab.started)
            assert not [name for name, count in once.items() if count > 1], once


RandomMaster.TestCase.settings = settings(
    max_examples=(2000 if os.environ.get('LD90_LONG_TESTS')
                  else settings.default.max_examples * 3 // 10),
    stateful_step_count=25,
    deadline=None)
TestRandomMaster = RandomMaster.TestCase
