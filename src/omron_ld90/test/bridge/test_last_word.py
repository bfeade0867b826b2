"""A person may stop the robot, or send it elsewhere, at any time.

No drive of the route may pass this command, and the route must end.
"""
from __future__ import annotations

from dataclasses import fields
from functools import lru_cache
from typing import Callable, Sequence, Tuple

import pytest
from bridge_builders import DOCK_VERTEX, yard
from delayed_drive import DelayedDrive
from hypothesis import given, note, settings
from hypothesis import strategies as st
from modelled_controller import Delays
from speaking_robot import UNDOCKING_TIME

from omron_ld90.bridge import events as p

YARD = yard()  # one object, because it caches what is computed about its corners
ROUTES = ((1, 5, 6), (1, 2, 3, 4), (1, -1, 9), (1, 5), (-9, 1))
LONGEST_DRIVE = 60.0  # s, longest time of these routes
LONGEST_END = 45.0  # s until the end of a drive is known: docking may be tried several times
LONGEST_STOP = 8.0  # s until the bridge gives a failed stop again, in every case
SECONDS = st.sampled_from([0.0, 0.01, 0.05, 0.2])
MOMENTS = st.one_of(
    st.tuples(st.just('order'), st.just(1), st.floats(0.0, 25.0)),
    st.tuples(st.sampled_from(['give', 'let through', 'arrival', 'up', 'bridge is back']),
              st.integers(1, 4), st.one_of(SECONDS, st.floats(0.0, 1.2))))
# near the n-th drive or arrival of the route, at the times of `planned_moments`
NEAR_ONE = st.tuples(st.just('as planned'), st.integers(1, 12), st.floats(-0.8, 0.3))
STOPS = st.sampled_from(['stop_by_topic', 'stop_by_cancelling', 'stop_at_robot', 'send_elsewhere'])
TROUBLES = st.lists(st.tuples(MOMENTS, st.one_of(
    st.tuples(st.just('cut'), st.sampled_from(list(p.Link)), st.floats(0.1, 5.0)),
    st.tuples(st.just('restart_bridge'), st.floats(0.1, 4.0)),
    st.tuples(st.just('restart_controller')))), max_size=2)


def start_of(edges: Tuple[int, ...]) -> int:
    """The vertex at which a route begins."""
    return YARD.start_vertex(edges[0]).id


@lru_cache(maxsize=None)
def planned_moments(strategy: str, edges: Tuple[int, ...]) -> Sequence[float]:
    """Seconds from the order to each drive and each arrival of a route without delays."""
    drive = DelayedDrive(YARD, start_of(edges), strategy, Delays(), 'name', 0.0)
    moments = []
    drive.watchers.append(lambda what: moments.append(drive.now) if what != 'order' else None)
    start = drive.now
    drive.order(7, *edges)
    drive.run(LONGEST_DRIVE, lambda: drive.has_ended)
    return [moment - start for moment in moments]


def at(drive: DelayedDrive, moment: Tuple[str, int, float], call: Callable[[], None]) -> None:
    """Calls a function some time after an event of the drive has happened for the n-th time."""
    what, count, seconds = moment
    happened = []

    def watch(now: str) -> None:
        if what in now:
            happened.append(now)
            if len(happened) == count:
                drive.later(seconds, call)
    drive.watchers.append(watch)


@settings(max_examples=settings.default.max_examples * 5 // 3)
@given(st.sampled_from(['rolling', 'vertex_by_vertex', 'direct']), st.sampled_from(ROUTES),
       st.builds(Delays, **{way.name: SECONDS for way in fields(Delays)}),
       st.sampled_from(['name', 'coordinates', 'nothing']), st.sampled_from([0.0, 0.3, 1.5]),
       TROUBLES, st.one_of(NEAR_ONE, NEAR_ONE, MOMENTS), STOPS)
def test_nothing_of_a_route_passes_a_persons_stop(
        strategy, edges, delays, interruption, braking, troubles, moment, stop):
    drive = DelayedDrive(YARD, start_of(edges), strategy, delays, interruption, braking)
    for when, (trouble, *how) in troubles:
        at(drive, when, lambda trouble=trouble, how=how: getattr(drive, trouble)(*how))
    if moment[0] == 'as planned':
        _, count, seconds = moment
        planned = planned_moments(strategy, edges)
        moment = ('order', 1, max(planned[count % len(planned)] + seconds, 0.0))
    at(drive, moment, getattr(drive, stop))
    drive.order(7, *edges)
    drive.run(LONGEST_DRIVE, lambda: drive.stopped_at is not None or drive.has_ended)
    if drive.stopped_at is None:
        return
    drive.run(LONGEST_END, lambda: drive.crossed or drive.has_ended)
    drive.run(LONGEST_STOP, lambda: drive.crossed)
    drive.run(LONGEST_STOP, lambda: drive.crossed or drive.has_ended)
    note('\n'.join(drive.trace))
    assert not drive.passed
    if not drive.crossed:
        assert drive.has_ended
    if not drive.crossed and stop != 'send_elsewhere':
        assert drive.robot.goal is None, 'the robot drives on'
        assert is_driven_again(drive)


DIALECTS = ['name', 'status', 'coordinates']
OUT_OF_DOCK, INTO_DOCK = (DOCK_VERTEX, (-9, 1)), (1, (9,))


@pytest.mark.parametrize('interruption', DIALECTS)
@pytest.mark.parametrize('braking', [0.0, 0.3])
@pytest.mark.parametrize('stop', ['stop_by_topic', 'stop_by_cancelling', 'stop_at_robot'])
@pytest.mark.parametrize(('vertex', 'edges'), [OUT_OF_DOCK, INTO_DOCK])
def test_a_stop_ends_a_route_as_soon_while_the_robot_leaves_its_dock_or_docks(
        vertex, edges, stop, braking, interruption):
    drive = DelayedDrive(YARD, vertex, 'rolling', Delays(), interruption, braking)
    drive.order(7, *edges)
    drive.run(UNDOCKING_TIME / 2.0)
    getattr(drive, stop)()
    drive.run(braking + 1.0)
    assert drive.has_ended
    assert len(drive.robot.commands) == 1, 'no other command may be given'


@pytest.mark.parametrize('interruption', [*DIALECTS, 'nothing'])
@pytest.mark.parametrize(('vertex', 'edges', 'end'), [
    (*OUT_OF_DOCK, 2), (*INTO_DOCK, DOCK_VERTEX)])
def test_a_robot_that_leaves_its_dock_or_docks_completes_its_route(
        vertex, edges, end, interruption):
    drive = DelayedDrive(YARD, vertex, 'rolling', Delays(), interruption, 0.3)
    drive.order(7, *edges)
    drive.run(LONGEST_DRIVE, lambda: drive.has_ended)
    assert [line for line in drive.trace if 'failed' in line] == []
    assert drive.robot.position == YARD.vertex(end).position


def is_driven_again(drive: DelayedDrive) -> bool:
    """True if a new order drives the robot from its place, once there is no fault any more."""
    drive.watchers.clear()
    drive.spared = True
    drive.run(LONGEST_STOP, lambda: drive.is_well)
    edge, on_it = YARD.nearest_edge(*drive.robot.position)
    sent = []
    at(drive, ('let through', 1, 0.0), lambda: sent.append(drive.now))
    drive.order(8, edge if on_it.fraction < 0.5 else -edge)
    return drive.run(LONGEST_STOP, lambda: bool(sent))
