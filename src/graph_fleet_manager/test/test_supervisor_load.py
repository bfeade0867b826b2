"""Thousands of missions that wait do not delay urgent events."""
from __future__ import annotations

from collections import Counter

import pytest
from fleet_builders import AGV, corridor

from fleet_core.interlocking.reports import Report
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.tasks import PlanningOutcome
from fleet_core.supervision import assignment
from fleet_core.supervision.actions import SendRoute
from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import MissionState, Request
from fleet_core.supervision.outbox import TOGETHER
from fleet_core.supervision.questions import question_of
from fleet_core.supervision.settings import RobotSettings
from fleet_core.supervision.waiting_missions import AT_ONCE
from graph_fleet_manager.nodes.event_loop import BATCH, SupervisorEvents
from world.supervised_fleet import SupervisedFleet

MANY = 2000


@pytest.fixture
def fleet():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.run(1.0)
    return fleet


@pytest.fixture
def looked_at(monkeypatch):
    """Returns how often the supervisor has looked at each mission, by id."""
    counter = Counter()
    original = assignment.hindrances

    def counted(mission, *more):
        counter[mission.request.id] += 1
        return original(mission, *more)
    monkeypatch.setattr(assignment, 'hindrances', counted)
    return counter


def test_thousands_of_requests_take_one_commit_for_each_batch(fleet):
    loop = SupervisorEvents(lambda: fleet.now)
    loop.next_event()
    loop.begin()
    for id in range(MANY):
        loop.put_request(Request(id + 1, (3,)))
    before = fleet.disk.journal.commits
    for _ in range(MANY // BATCH):
        fleet.do(loop.next_event()(fleet.supervisor, fleet.now))
    assert fleet.disk.journal.commits - before == MANY // BATCH
    assert Counter(fleet.told(id + 1)[-1] for id in range(MANY)) == {MissionState.PENDING: MANY}


def test_no_tick_report_or_command_looks_at_all_missions(fleet, looked_at, monkeypatch):
    fleet.do(fleet.supervisor.requests([Request(id + 1, (3,)) for id in range(MANY)], fleet.now))
    with monkeypatch.context() as patched:
        patched.setattr(MissionBook, 'open', property(lambda book: pytest.fail('looked at all')))
        for _ in range(30):
            before = sum(looked_at.values())
            fleet.step()
            most = 3 * (len(fleet.agvs) + AT_ONCE)  # one tick, and two answers of the planner
            assert sum(looked_at.values()) - before <= most
    assert fleet.state(1) is fleet.state(2) is MissionState.ACTIVE, (
        'the oldest missions must be served')


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
    """Missions for a robot that is out of service do not delay the other robot."""
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


def test_what_reports_change_shares_a_commit_with_what_follows_within_40_ms():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)},
                            settings=RobotSettings(release_ahead=20.0))
    fleet.request(1, 8)
    fleet.run_until(lambda: fleet.agvs['a'].is_driving)
    fleet.run(1.0)
    supervisor, agv, before = fleet.supervisor, fleet.agvs['a'], fleet.disk.journal.commits

    def complete_edge() -> None:
        agv.drive(2.0)
        assert supervisor.report('a', Report(agv.report(fleet.now)), fleet.now) == []
    complete_edge()
    complete_edge()
    assert fleet.disk.journal.commits == before, 'a report must wait for the tick'
    assert supervisor.tick_due <= fleet.now, 'the last commit is old, so the tick must come at once'
    fleet.do(supervisor.tick(fleet.now))
    assert fleet.disk.journal.commits == before + 1 and supervisor.tick_due is None
    complete_edge()
    assert supervisor.tick_due == pytest.approx(fleet.now + TOGETHER)


def test_a_stop_does_not_wait_for_what_else_is_to_be_stored():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.run(1.0)
    fleet.request(1, 8)
    fleet.run(1.0)
    fleet.agvs['a'].drive(3.0)
    fleet.supervisor.report('a', Report(fleet.agvs['a'].report(fleet.now)), fleet.now)
    actions = fleet.supervisor.stop_fleet(fleet.now)
    assert any(isinstance(action, SendRoute) and not action.edges for action in actions)


def test_a_disk_that_fails_makes_nobody_look_at_the_clock_more_often():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1)})
    fleet.request(1, 8)
    fleet.run(1.0)
    fleet.disk.fails()
    fleet.run(3.0)
    assert fleet.supervisor.trouble and fleet.supervisor.tick_due is None


def test_robots_get_edges_while_the_planner_works_for_others():
    fleet = SupervisedFleet(corridor(12, spacing=1.0), {'a': (AGV, 1), 'b': (AGV, 12)},
                            planning=1.5)
    fleet.run(1.0)
    before = len(fleet.planner.plans)
    fleet.request(1, 6, robot='a')
    fleet.run_until(lambda: fleet.agvs['a'].is_driving)
    fleet.request(2, 8, robot='b')
    fleet.run(0.1)
    executor, record = fleet.supervisor.plan_executor, fleet.supervisor.robots['a'].record
    granted = record.end
    fleet.run_until(lambda: record.end > granted, 5.0)
    assert executor.is_planning, 'the report had to wait for the planner'
    fleet.run_until_done(1, 2)
    assert len(fleet.planner.plans) - before <= 3, 'grants made meanwhile made plans useless'


def test_an_answer_by_which_another_robot_goes_first_is_not_used():
    """While the planner works, `a` is granted a place that in the new plan `b` must leave first."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)}, planning=0.0)
    fleet.run(1.0)
    fleet.request(1, 4, robot='a')
    fleet.run_until(lambda: fleet.agvs['a'].is_driving)
    supervisor = fleet.supervisor
    world = supervisor._world()
    question = question_of(world, supervisor.plan_executor.plan, 0, fleet.now)
    own = supervisor.plan_executor.plan.plans['a']
    base = question.assumptions.robots['a'].base
    drives = {'a': own.drives[base - own.base:], 'b': ()}
    record = supervisor.robots['a'].record
    end = record.end
    fleet.run_until(lambda: record.end > end)
    free = PlanningOutcome(drives, ())
    assert question.plan(free, world) is not None
    behind_b = PlanningOutcome(drives, (Constraint('b', 1, 0.0, 'a', end - base),))
    assert question.plan(behind_b, world) is None
