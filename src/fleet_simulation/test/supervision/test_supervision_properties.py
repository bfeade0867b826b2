"""A fleet keeps the promises of docs/explanation/fleet.md, under all events.

- No robots collide, and no robot holds a place to which another robot may still drive.
- A command of a person has precedence over everything else.
- No accepted mission is lost or driven twice.
- All missions end when the trouble ends.
"""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, List, Sequence

import pytest
from fleet_builders import AGV, corridor
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from proofs import LONG, is_whole

from fleet_core.fleet import RobotType
from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.settings import RobotSettings
from fleet_simulation.virtual_fleet import Crash
from world.chaos import (
    DOCKS,
    PARKING,
    PEOPLE,
    ROBOTS,
    SAME,
    TROUBLE,
    YARD,
    Act,
    Chaos,
    Event,
)
from world.supervised_fleet import SupervisedFleet

WHOLE = is_whole(__file__)
EXAMPLES = max(1, settings.default.max_examples // (4 if WHOLE else 12))
SLOW = RobotType('slow', 0.4, 0.3)
PAUSES = st.sampled_from((0.1, 0.3, 0.8, 2.0, 4.0))
MOMENTS = st.sampled_from(('now', 'now', 'order', 'plan'))


@st.composite
def fleets(draw: st.DrawFn) -> SupervisedFleet:
    """Draws a fleet whose messages are lost and repeated, and whose planner takes some time."""
    kinds = [replace(kind, docks=frozenset(DOCKS))
             for kind in (AGV, AGV, draw(st.sampled_from((AGV, SLOW))))]
    return SupervisedFleet(
        YARD, {name: (kind, 21 + k) for k, (name, kind) in enumerate(zip(ROBOTS, kinds))},
        seed=draw(st.integers(0, 1000)), loss=draw(st.sampled_from((0.0, 0.0, 0.05, 0.3))),
        repeats=draw(st.sampled_from((0.0, 0.2))),
        planning=draw(st.sampled_from((0.05, 0.3, 1.5))), parking=PARKING,
        switches=draw(st.booleans()),
        settings=RobotSettings(release_ahead=draw(st.sampled_from((0.0, 3.0, 8.0)))))


@st.composite
def lives(draw: st.DrawFn) -> List[Event]:
    """Draws a list of events: first missions, then acts of people and a few kinds of faults."""
    def some(acts: Dict[str, Act], most: int) -> List[str]:
        return draw(st.lists(st.sampled_from(sorted(acts)), min_size=1, max_size=most,
                             unique=True))

    numbers = st.integers(0, 60)
    acts = st.one_of(*map(st.sampled_from, (['request'], some(PEOPLE, 6), some(TROUBLE, 4),
                                            some(TROUBLE, 1))))
    events = st.builds(Event, acts, MOMENTS, st.sampled_from((SAME, SAME, 0, 0, 1, 2)), numbers,
                       PAUSES)
    count = draw(st.integers(4, 25))
    return [*(Event('request', number=number, pause=1.0)
              for number in draw(st.lists(numbers, min_size=1, max_size=3))),
            *draw(st.lists(events, min_size=count, max_size=count))]


@settings(max_examples=1000 if LONG else EXAMPLES, deadline=None,
          suppress_health_check=list(HealthCheck))
@given(fleets(), lives())
def test_whatever_happens_to_a_fleet_its_promises_are_kept(fleet: SupervisedFleet,
                                                           life: List[Event]) -> None:
    chaos = Chaos(fleet)
    for event in life:
        chaos.happen(event)
    chaos.end()
    check_orders(fleet.sent)


def test_what_a_robot_held_on_another_graph_blocks_nobody_for_ever() -> None:
    """For a moment, the graph lacks an edge that is behind a driving robot."""
    kind = replace(AGV, docks=frozenset(DOCKS))
    fleet = SupervisedFleet(YARD, {name: (kind, 21 + k) for k, name in enumerate(ROBOTS)},
                            planning=0.05, parking=PARKING,
                            settings=RobotSettings(release_ahead=3.0))
    test_whatever_happens_to_a_fleet_its_promises_are_kept.hypothesis.inner_test(fleet, [
        Event('request', pause=1.0), Event('request', robot=SAME, pause=0.1),
        Event('request', robot=SAME, pause=0.3),
        Event('request', 'order', robot=SAME, pause=2.0),
        Event('change_graph', robot=SAME, pause=0.1)])


def check_orders(sent: Sequence[SendRoute], may_shorten: bool = True) -> None:
    """Checks that released edges stay released.

    - The numbers of the orders to one robot grow, and only the last order is sent again.
    - In one epoch, each number in the route record keeps its edge, unless orders may be refused, or
      become shorter because a mission was cancelled or paused.
    """
    last: Dict[str, SendRoute] = {}
    for order in sent:
        before = last.get(order.robot)
        last[order.robot] = order
        if before is None:
            assert not order.repeated, order
        elif order.repeated or order.order.number == before.order.number:
            assert before.order == order.order, (before, order)  # also after a restart
        else:
            now, was = order.order, before.order
            assert now.number > was.number, (before, order)
            if not may_shorten and now.edges and was.edges and now.epoch == was.epoch:
                begin = max(now.first, was.first)
                assert now.end >= was.end and now.steps(begin)[:len(was.steps(begin))] == (
                    was.steps(begin)), (before, order)


def swap(crash_at: int) -> SupervisedFleet:
    """Lets two robots swap places in a corridor while the supervisor crashes at one commit."""
    fleet = SupervisedFleet(corridor(5, siding_at=3), {'a': (AGV, 1), 'b': (AGV, 5)},
                            settings=RobotSettings(release_ahead=3.0))
    fleet.crash = Crash(crash_at)
    for id, (vertex, robot) in enumerate(((5, 'a'), (1, 'b')), 1):
        fleet.request(id, vertex, robot=robot)
        if fleet.supervisor.book.find(id) is None:
            fleet.request(id, vertex, robot=robot)
    fleet.run_until_done(1, 2)
    assert [fleet.state(id) for id in (1, 2)] == [MissionState.SUCCEEDED] * 2
    check_orders(fleet.sent, may_shorten=False)
    return fleet


def test_the_supervisor_may_die_at_every_single_commit() -> None:
    whole = swap(crash_at=10 ** 6)
    for commit in range(1, whole.disk.journal.commits + 1, 1 if LONG else 3 if WHOLE else 9):
        fleet = swap(commit)
        for name, agv in fleet.agvs.items():
            assert agv.visited[-1] == whole.agvs[name].visited[-1], f'death at commit {commit}'
            assert agv.travelled == pytest.approx(whole.agvs[name].travelled), (
                f'death at commit {commit}: {name} drove another route')
