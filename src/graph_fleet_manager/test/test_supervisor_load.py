"""Thousands of missions wait, and what cannot wait is not slower for that."""
from __future__ import annotations

from collections import Counter

import pytest
from fleet_builders import AGV, corridor

from fleet_simulation.supervised_fleet import SupervisedFleet
from graph_fleet_manager.nodes.event_loop import BATCH, EventLoop
from graph_fleet_manager.supervision import assignment
from graph_fleet_manager.supervision.mission_book import MissionBook
from graph_fleet_manager.supervision.missions import MissionState, Request
from graph_fleet_manager.supervision.waiting_missions import AT_ONCE

MANY = 2000


@pytest.fixture
def fleet():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.run(1.0)
    return fleet


@pytest.fixture
def looked_at(monkeypatch):
    """How often each mission was looked at."""
    counter = Counter()
    original = assignment._why_nobody

    def counted(mission, *more):
        counter[mission.request.id] += 1
        return original(mission, *more)
    monkeypatch.setattr(assignment, '_why_nobody', counted)
    return counter


def test_thousands_of_requests_take_one_commit_for_each_batch(fleet):
    loop = EventLoop(lambda: fleet.now)
    loop.take()
    loop.begin()
    for id in range(MANY):
        loop.put_request(Request(id + 1, (3,)))
    before = fleet.journal.commits
    for _ in range(MANY // BATCH):
        fleet.do(loop.take()(fleet.supervisor, fleet.now))
    assert fleet.journal.commits - before == MANY // BATCH
    assert Counter(fleet.told(id + 1)[-1] for id in range(MANY)) == {MissionState.PENDING: MANY}


def test_no_tick_report_or_command_looks_at_all_missions(fleet, looked_at, monkeypatch):
    fleet.do(fleet.supervisor.requests([Request(id + 1, (3,)) for id in range(MANY)], fleet.now))
    with monkeypatch.context() as patched:
        patched.setattr(MissionBook, 'open', property(lambda book: pytest.fail('it looks at all')))
        for _ in range(30):
            before = sum(looked_at.values())
            fleet.step()
            most = 3 * (len(fleet.agvs) + AT_ONCE)  # a tick, and two answers of the planner
            assert sum(looked_at.values()) - before <= most
    assert fleet.state(1) is fleet.state(2) is MissionState.ACTIVE, 'the oldest ones are served'


def test_every_mission_is_told_what_it_waits_for_in_its_turn(fleet):
    fleet.do(fleet.supervisor.requests([Request(id + 1, (3,)) for id in range(10 * AT_ONCE)],
                                       fleet.now))
    fleet.run(2.0)
    waiting = [mission for mission in fleet.supervisor.book.open
               if mission.state is MissionState.PENDING]
    assert {mission.reason for mission in waiting} == {'it waits for a robot to be free'}


def test_a_stop_is_told_to_every_waiting_mission_in_its_turn(fleet):
    fleet.do(fleet.supervisor.requests([Request(id + 1, (3,)) for id in range(3 * AT_ONCE)],
                                       fleet.now))
    fleet.run(1.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(1.0)
    waiting = [mission for mission in fleet.supervisor.book.open
               if mission.state is MissionState.PENDING]
    assert {mission.reason for mission in waiting} == {'the fleet is stopped'}


def test_missions_that_no_robot_can_serve_do_not_keep_the_others_from_a_robot():
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.close(4)
    fleet.run(1.0)
    fleet.do(fleet.supervisor.requests(
        [*(Request(id + 1, (6,)) for id in range(10 * AT_ONCE)), Request(10000, (3,))],
        fleet.now))
    fleet.run_until(lambda: fleet.state(10000) is MissionState.SUCCEEDED, 30.0)


def test_the_missions_of_each_robot_wait_for_it_alone(fleet):
    """Those for a robot that is out of service do not keep the other robot waiting."""
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.do(fleet.supervisor.requests(
        [*(Request(id + 1, (3,), robot='a', priority=5) for id in range(10 * AT_ONCE)),
         Request(10000, (6,), robot='b')], fleet.now))
    fleet.run(1.0)
    assert fleet.state(10000) is MissionState.ACTIVE


@pytest.mark.parametrize('restarts', [False, True])
def test_the_book_knows_who_waits_whatever_happens_to_missions(fleet, restarts):
    fleet.request(1, 3, robot='a')
    fleet.request(2, 3, robot='a', priority=-1)
    fleet.request(3, 3, robot='a', priority=1)
    fleet.request(4, 3)
    fleet.run(0.3)
    if restarts:
        fleet.restart()
    pending = fleet.supervisor.book.pending
    waiting = [mission.request.id for mission in pending.behind((-100, 0), 10)]
    assert waiting == [id for id in (3, 1, 4, 2) if fleet.state(id) is MissionState.PENDING]
    fleet.run_until_done(1, 2, 3, 4)
    assert not fleet.supervisor.book.pending
