"""Each open mission that makes no progress shows why it waits, and why no robot serves it."""
from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import isnan
from typing import FrozenSet, Optional, Set, Tuple

import pytest
from fleet_builders import AGV, corridor, with_docks
from test_work_at_stops import GIVE, TAKE, WorkingFleet
from test_work_in_every_order import DISTURBED, Life

from fleet_core.supervision import why as why_module
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.hindrances import WORDS, Hindrance
from fleet_core.supervision.missions import CommandKind, MissionState
from fleet_core.supervision.waits import NO_WAIT, WaitCode
from fleet_core.supervision.why import MissionReason, RobotReason, mission_reason
from fleet_core.work.dependencies import Dependency
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import Actor
from fleet_core.work.stops import WorkStep as Step
from fleet_core.work.stops import WorkStop as Stop
from fleet_simulation.virtual_fleet import VirtualFleet
from route_protocol.steps import Word
from world.supervised_fleet import SupervisedFleet

TRUCK = replace(AGV, name='truck')
LIVES = 6


def why(fleet: VirtualFleet, id: int) -> MissionReason:
    """Returns the reason why a mission waits."""
    mission = fleet.supervisor.book.find(id)
    assert mission is not None
    return mission_reason(mission, fleet.supervisor, fleet.now)


def why_not(fleet: VirtualFleet, id: int, robot: str = 'a') -> RobotReason:
    """Returns the reason why a robot does not serve a mission."""
    return next(one for one in why(fleet, id).robots if one.robot == robot)


def code(fleet: VirtualFleet, id: int = 1) -> WaitCode:
    return why(fleet, id).wait.code


# -- the property ---------------------------------------------------------------------------------


def silent_mission(fleet: VirtualFleet) -> Optional[str]:
    """Returns an open mission that makes no progress and shows no reason; None: there is none.
    """
    for mission in fleet.supervisor.book.open:
        told = why(fleet, mission.request.id)
        robot = fleet.supervisor.robots.get(mission.robot)
        goes_on = robot is not None and (robot.record.ahead or not robot.record.is_standing)
        if not goes_on and not (told.wait.code and told.wait.text):
            return f'{mission}: {told}\n{fleet.picture()}'
        if mission.state is MissionState.PENDING and (
                [one.robot for one in told.robots] != list(fleet.supervisor.robots)
                or not all(one.text for one in told.robots)):
            return f'{mission}: {told}'
        if told.wait.code is WaitCode.ROBOT and not any(
                one.hindrance for one in told.robots) and len(fleet.supervisor.book.pending) == 1:
            return f'{mission}: every robot could serve it, and none does: {told}'
    return None


@lru_cache(maxsize=None)
def lived(seed: int) -> Tuple[Optional[str], FrozenSet[object]]:
    """Returns the first silent mission of a random run, and all causes of waiting that occurred."""
    life = Life(seed)
    found: Set[object] = set()
    for _ in range(DISTURBED):
        life.disturb()
        life.step()
        silent = silent_mission(life)
        if silent is not None:
            return silent, frozenset(found)
        for mission in life.supervisor.book.open:
            told = why(life, mission.request.id)
            found |= {told.wait.code, *(one.hindrance for one in told.robots)}
    life.end()
    return None, frozenset(found)


@pytest.mark.parametrize('seed', range(LIVES))
def test_every_open_mission_that_does_not_go_on_has_a_reason(seed):
    assert lived(seed)[0] is None


@pytest.mark.parametrize('left_out', ['_NEXT_PLAN', '_PAUSED', 'FLEET_STOPPED'])
def test_a_reason_that_is_left_out_is_found(left_out, monkeypatch):
    monkeypatch.setattr(why_module, left_out, NO_WAIT)
    fleet, found = two_robots(), []
    fleet.request(1, 6, robot='a')
    for change in (None, CommandKind.PAUSE, CommandKind.RESUME, None):
        if change is not None:
            fleet.do(fleet.supervisor.command(1, change, fleet.now))
        elif found:
            fleet.do(fleet.supervisor.stop_fleet(fleet.now))
        for _ in range(40):
            fleet.step()
            found.append(silent_mission(fleet))
    assert any(found), f'nothing is silent without {left_out}'


def test_the_lives_reach_the_reasons():
    found = frozenset().union(*(lived(seed)[1] for seed in range(LIVES)))
    assert found >= {WaitCode.NOTHING, WaitCode.ROBOT, WaitCode.START, WaitCode.RESUME_FLEET,
                     WaitCode.PERSON, WaitCode.STEP, WaitCode.PLAN, WaitCode.TRAFFIC,
                     Hindrance.BUSY, Hindrance.LADEN, Hindrance.HALTED}


# -- why a robot does not serve a mission ---------------------------------------------------------


def two_robots(**more: object) -> SupervisedFleet:
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (TRUCK, 8)}, **more)
    fleet.run(1.0)
    return fleet


def test_a_robot_of_another_type_or_name_does_not_serve_a_mission():
    fleet = two_robots()
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.request(1, 3, robot_type='truck')
    fleet.request(2, 3, robot='b')
    fleet.run(1.0)
    assert why_not(fleet, 1).hindrance is Hindrance.OTHER_TYPE
    assert why_not(fleet, 2).hindrance is Hindrance.OTHER_ROBOT
    reason = why_not(fleet, 1, 'b')
    assert (reason.robot, reason.hindrance, reason.text) == (
        'b', Hindrance.OUTAGE, 'it cannot work: it was taken out of service')
    assert reason.mission is None and isnan(reason.until)
    assert why(fleet, 1).wait.text == fleet.supervisor.book.find(1).reason


def test_a_robot_that_may_not_be_sent_to_a_dock_does_not_serve_a_mission():
    kind = replace(AGV, docks=frozenset((6,)))
    fleet = SupervisedFleet(with_docks(corridor(6), 6), {
        'a': (replace(kind, name='b', docks=frozenset()), 1), 'b': (kind, 3)})
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.request(1, 6)
    fleet.run(1.0)
    assert why_not(fleet, 1).hindrance is Hindrance.DOCK


def test_a_robot_that_serves_another_mission_says_until_when():
    fleet = two_robots()
    fleet.request(1, 6, robot='a')
    fleet.run(2.0)
    fleet.request(2, 2, robot='a')
    fleet.run(0.5)
    told = why_not(fleet, 2)
    assert (told.hindrance, told.mission, told.text) == (
        Hindrance.BUSY, 1, 'it serves mission 1')
    assert why(fleet, 2).wait == (WaitCode.ROBOT, 'it waits for a to be free', told.until)
    begun = fleet.now
    fleet.run_until_done(1)
    assert told.until == pytest.approx(fleet.now - begun, abs=5.0)


def test_a_robot_with_the_load_of_an_ended_mission_serves_none():
    fleet = WorkingFleet()
    fleet.send(1, Stop(1, steps=(TAKE,)))
    fleet.run_until_done(1)
    fleet.request(2, 3)
    fleet.run(1.0)
    assert why_not(fleet, 2).hindrance is Hindrance.LADEN
    fleet.set_load('a')
    fleet.run_until_done(2)


def test_a_robot_without_charge_or_way_does_not_serve_a_mission():
    fleet = two_robots()
    fleet.do(fleet.supervisor.battery('a', 0.16, fleet.now))
    fleet.close(4)
    fleet.request(1, 7, robot='a')
    fleet.run(1.0)
    assert why_not(fleet, 1).hindrance is Hindrance.MUST_CHARGE
    fleet.do(fleet.supervisor.battery('a', 0.9, fleet.now))
    fleet.run(1.5)
    assert why_not(fleet, 1).hindrance is Hindrance.NO_WAY
    fleet.close()
    fleet.run_until_done(1)


def test_a_robot_that_was_stopped_does_not_serve_a_mission_and_says_so():
    fleet = two_robots()
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.request(1, 3)
    fleet.run(1.0)
    assert code(fleet) is WaitCode.RESUME_FLEET
    assert why_not(fleet, 1).hindrance is Hindrance.HALTED


def test_each_hindrance_has_words():
    assert set(WORDS) == set(Hindrance)


# -- what a mission waits for ---------------------------------------------------------------------


def test_a_mission_that_drives_waits_for_nothing():
    fleet = two_robots()
    fleet.request(1, 6, robot='a')
    fleet.run(3.0)
    assert why(fleet, 1) == MissionReason((WaitCode.NOTHING, '', pytest.approx(
        float('nan'), nan_ok=True)))


def test_a_mission_waits_for_the_missions_before_it_and_for_its_resumption():
    fleet = two_robots()
    fleet.request(1, 6, robot='a')
    fleet.request(2, 7, after=(Dependency(1),))
    fleet.run(1.0)
    assert code(fleet, 2) is WaitCode.MISSIONS
    fleet.do(fleet.supervisor.command(1, CommandKind.PAUSE, fleet.now))
    fleet.run(5.0)
    assert code(fleet) is WaitCode.RESUME


def test_a_mission_waits_for_the_end_of_its_stay():
    fleet = two_robots()
    fleet.request(1, 1, 4, robot='a', dwells=(30.0, 0.0))
    fleet.run(10.0)
    wait = why(fleet, 1).wait
    assert wait.code is WaitCode.STAY and wait.until == pytest.approx(21.0, abs=2.0)


def test_a_mission_waits_for_its_step_and_then_for_a_person():
    fleet = WorkingFleet()
    fleet.steps['a'].fail_next(Word.RUNNING, 1)
    fleet.send(1, Stop(1, steps=(Step('work', 20.0),)))
    fleet.run_until(lambda: fleet.steps['a'].running)
    fleet.run(1.0)
    wait = why(fleet, 1).wait
    assert (wait.code, wait.text) == (WaitCode.STEP, 'step 1 (work) of stop 1')
    assert wait.until == pytest.approx(19.0, abs=1.0)
    fleet.run_until_asked(1)
    assert code(fleet) is WaitCode.PERSON and 'mission answer 1' in why(fleet, 1).wait.text


def test_a_mission_waits_for_its_robot_and_the_disk():
    fleet = two_robots()
    fleet.request(1, 6, robot='a')
    fleet.run(3.0)
    fleet.lose_link('a')
    fleet.run(3.0)
    assert code(fleet) is WaitCode.OUTAGE
    fleet.find_link('a')
    fleet.disk.fails()
    fleet.request(2, 5)
    assert fleet.supervisor.all_wait.code is WaitCode.DISK


def test_a_robot_says_the_same_as_its_mission():
    fleet = WorkingFleet('a', 'b')
    fleet.send(1, Stop(3, steps=(Step('by hand', 900.0, actor=Actor.PERSON), TAKE)),
               Stop(5, steps=(GIVE,)), robot='a')
    fleet.run_until(lambda: code(fleet) is WaitCode.STEP)
    assert robot_views(fleet.supervisor, fleet.now)[0].waits_for == why(fleet, 1).wait
    fleet.answer(1, StepDecision.DONE)
