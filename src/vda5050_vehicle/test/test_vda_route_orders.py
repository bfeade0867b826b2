"""The route driver and the vehicle's end of the route protocol, in all states that they reach.

Orders and reports are lost, come late or twice, and overtake each other. Both ends restart with
their memory, without it, or with an older one. People and other programs drive, stop and command
the robot, which refuses orders, fails and rolls on. In each state within the bounds:

* the robot enters only released edges, and none for an order whose cancellation is FINISHED;
* after a person or another program stopped or drove the robot, it waits for the VDA master;
* no number is drawn twice;
* a held or cancelled robot gets the stop, and can then be brought to a new node.

Further tests plant faults in the driver, and the search finds each fault.
"""
from __future__ import annotations

from dataclasses import replace

import pytest
from proofs import LONG, is_whole
from route_world import RouteWorld

from route_protocol.messages import WrongReport
from vda5050_vehicle.drivers.route_driver import RouteDriver

WHOLE = is_whole(__file__)
MOST = 10 ** 7 if WHOLE else 2_000  # number of states that a search visits, the nearest first

BOUNDS = {
    'a cancellation': {'order': 2, 'cancel': 1, 'report': 2},
    'another giver or master': {'order': 1, 'other': 1, 'report': 1},
    'a restart of the adapter': {'order': 1, 'restart': 1, 'report': 2, 'cancel': 1},
    'an older journal': {'order': 1, 'restart': 1, 'journal': 1, 'report': 1, 'cancel': 1},
    'a restart of the bridge': {'order': 1, 'reboot': 1, 'report': 1},
    'a refusal': {'order': 1, 'update': 1, 'refusal': 1, 'report': 1, 'stopPause': 1},
    'a failure': {'order': 1, 'update': 1, 'failure': 1, 'report': 1},
    'silence': {'order': 1, 'update': 1, 'silence': 1, 'report': 1},
}
NEW = {
    'both are new': {'order': 1, 'report': 3, 'cancel': 1},
    'both are new, and the journal is an older one': {
        'order': 1, 'report': 2, 'restart': 1, 'journal': 1, 'cancel': 1},
}
if LONG:
    BOUNDS['a refusal and a failure'] = {'order': 1, 'update': 1, 'failure': 1, 'refusal': 1,
                                         'report': 2, 'stopPause': 1}


@pytest.mark.parametrize('name', [*BOUNDS, *NEW])
def test_nothing_is_driven_that_is_not_ordered_and_every_robot_can_be_used_again(name, capsys):
    found = RouteWorld().search({**BOUNDS, **NEW}[name], live=True, is_new=name in NEW,
                               most=MOST)
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


# --- planted faults -------------------------------------------------------------------------------

class DrawsAgain(RouteDriver):
    """A faulty driver that draws a number again after it has lost its journal."""

    def _next_number(self):
        return self.drive_state.protocol.number + 1


class IgnoresEpoch(RouteDriver):
    """A faulty driver that does not notice that a new epoch has begun."""

    def on_report(self, said, now):
        super().on_report(replace(said, epoch=self.drive_state.protocol.epoch or said.epoch), now)


class KeepsOpenOrders(RouteDriver):
    """A faulty driver that drops no open order."""

    def on_report(self, said, now):
        before = self.drive_state.protocol.open
        super().on_report(said, now)
        known = self.drive_state.protocol
        self._set(protocol=replace(known, open=tuple(dict.fromkeys((*before, *known.open)))))


class IgnoresCause(RouteDriver):
    """A faulty driver that drives on in a new epoch, regardless of the giver that began it."""

    def _judge_orders(self, before, said, news, now):
        super()._judge_orders(before, said, replace(news, cause=None), now)


class NeverFails(RouteDriver):
    """A faulty driver that drives on after each failure."""

    def _fail(self, reason):
        pass


class IgnoresUnknownOrders(RouteDriver):
    """A faulty driver that does not stop a robot that follows an order of a lost journal."""

    def _judge_orders(self, before, said, news, now):
        super()._judge_orders(before, said, replace(news, is_older=False), now)


class DoesNotLookForLostJournals(RouteDriver):
    """A faulty driver that treats a report as wrong if it shows an order that the journal lacks."""

    def on_report(self, said, now):
        if max(said.order, said.refused) > self.drive_state.protocol.number:
            raise WrongReport('it shows an unknown order')
        super().on_report(said, now)


class DoesNotHalt(RouteDriver):
    """A faulty driver that lets the robot drive on while the vehicle is held."""

    def halt(self, now):
        pass


class SendsOldStop(RouteDriver):
    """A faulty driver that repeats a stop that is under way instead of sending a newer stop."""

    def stop(self, now):
        if self.drive_state.protocol.is_stopping:
            self._send(now)
        else:
            super().stop(now)


class NeverRepeats(RouteDriver):
    """A faulty driver that sends each order only once."""

    def tick(self, now):
        pass


FAULTS = {
    DrawsAgain: 'a restart of the adapter',
    IgnoresEpoch: 'another giver or master',
    KeepsOpenOrders: 'a cancellation',
    IgnoresCause: 'another giver or master',
    NeverFails: 'another giver or master',
    IgnoresUnknownOrders: 'a restart of the adapter',
    DoesNotLookForLostJournals: 'a restart of the adapter',
    DoesNotHalt: 'a refusal',
    SendsOldStop: 'both are new, and the journal is an older one',
    NeverRepeats: 'a cancellation',
}


@pytest.mark.parametrize('fault', FAULTS, ids=lambda fault: fault.__name__)
def test_a_fault_of_the_driver_is_found(fault):
    name = FAULTS[fault]
    found = RouteWorld(fault).search({**BOUNDS, **NEW}[name], live=True, is_new=name in NEW,
                                     most=20_000)
    assert found.flaw, fault.__doc__
