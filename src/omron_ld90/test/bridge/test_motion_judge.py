"""The motion of the robot in the reports of the route protocol."""
from __future__ import annotations

from typing import Optional, Tuple

import pytest
from bridge_builders import Bench, yard

from omron_arcl import ActivityKind
from omron_arcl.records import MotionState
from omron_ld90.bridge import events as p
from omron_ld90.bridge.motion_judge import RESTING, STILL, MotionJudge
from omron_ld90.bridge.robot_state import MapLocation
from route_protocol.values import Motion, Phase

NANOSECONDS = 1_000_000_000
PLACE = (1.0, 2.0)


class Watched:
    """A judge, and a robot that reports twice a second."""

    def __init__(self) -> None:
        self.judge, self.now = MotionJudge(), 100.0

    def see(self, seconds: float = 0.5, place: Tuple[float, float] = PLACE,
            motion: ActivityKind = ActivityKind.STOPPED, runs: bool = False) -> None:
        end = self.now + seconds
        while self.now < end - 1e-9:
            self.now += 0.5
            stamp = int(self.now * NANOSECONDS)
            self.judge.seen(p.RobotSeen(stamp, motion, place=place), MapLocation(stamp, *place),
                            runs)

    def motion(self, runs: bool = False, is_known: bool = True, owes: bool = False) -> Motion:
        return self.judge.motion(runs, is_known, owes)


@pytest.fixture
def watched() -> Watched:
    """Returns the judge of a robot that was seen standing."""
    watched = Watched()
    watched.see(RESTING + 0.5)
    assert watched.motion() is Motion.STANDING
    return watched


def test_after_a_start_it_is_not_known_until_it_was_seen_standing():
    watched = Watched()
    watched.see(RESTING)
    assert watched.motion() is Motion.UNKNOWN
    watched.see()
    assert watched.motion() is Motion.STANDING


@pytest.mark.parametrize('runs, is_known, owes, motion', [
    (True, True, False, Motion.ON_ROUTE), (True, False, True, Motion.ON_ROUTE),
    (False, False, False, Motion.UNKNOWN), (False, True, False, Motion.STANDING),
    (False, True, True, Motion.COMING_TO_REST)])
def test_a_route_comes_first_then_what_is_known_then_the_owed_stop(watched, runs, is_known, owes,
                                                                   motion):
    assert watched.motion(runs, is_known, owes) is motion


@pytest.mark.parametrize('phase, motion', [
    (Phase.COMPLETE, Motion.ON_ROUTE), (Phase.FAILED, Motion.COMING_TO_REST),
    (Phase.STOPPED, Motion.COMING_TO_REST)])
def test_only_locations_after_the_end_of_a_route_show_that_it_stands(watched, phase, motion):
    watched.judge.route_ended(phase)
    assert watched.motion() is motion
    watched.see(RESTING)
    assert watched.motion() is motion
    watched.see()
    assert watched.motion() is Motion.STANDING


@pytest.mark.parametrize('motion', [
    ActivityKind.GOING_TO_GOAL, ActivityKind.STOPPING, ActivityKind.DOCKING,
    ActivityKind.UNDOCKING])
def test_a_robot_whose_status_shows_motion_does_not_stand(watched, motion):
    watched.judge.route_ended(Phase.FAILED)
    watched.see(5.0, motion=motion)
    assert watched.motion() is Motion.COMING_TO_REST


def test_a_robot_that_creeps_does_not_stand(watched):
    watched.judge.route_ended(Phase.FAILED)
    for step in range(20):
        watched.see(place=(PLACE[0] + 0.7 * STILL * step, PLACE[1]))
        assert watched.motion() is Motion.COMING_TO_REST


def test_a_robot_that_is_pushed_is_moved_until_it_stays(watched):
    watched.see(place=(PLACE[0] + 0.9 * STILL, PLACE[1]))
    assert watched.motion() is Motion.STANDING
    pushed = (PLACE[0] + 1.1 * STILL, PLACE[1])
    watched.see(place=pushed)
    assert watched.motion() is Motion.MOVED
    watched.see(RESTING, place=pushed)
    assert watched.motion() is Motion.STANDING


@pytest.mark.parametrize('told, motion', [
    *((p.MotionTold(2, state=state), Motion.MOVED)
      for state in (MotionState.DRIVING, MotionState.DOCKING, MotionState.UNDOCKING)),
    *((p.MotionTold(2, state=state), Motion.STANDING)
      for state in (MotionState.UNKNOWN, MotionState.STANDING, MotionState.STOPPING,
                    MotionState.DOCKED)),
    (p.MotionTold(2, is_ours=True, state=MotionState.DRIVING), Motion.STANDING),
    (p.MotionTold(2, is_ours=True, state=MotionState.MANUAL), Motion.MOVED)])
def test_a_robot_that_another_giver_or_a_hand_drives_is_moved_before_it_is_seen_to(
        watched, told, motion):
    watched.judge.told(told)
    assert watched.motion() is motion
    watched.see(5.0)
    assert watched.motion() is motion


def test_after_another_giver_it_must_be_seen_standing(watched):
    watched.judge.told(p.MotionTold(2, state=MotionState.DRIVING))
    watched.judge.told(p.MotionTold(2))
    assert watched.motion() is Motion.MOVED
    watched.see(RESTING + 0.5)
    assert watched.motion() is Motion.STANDING


@pytest.mark.parametrize('event, motion', [
    (None, Motion.ON_ROUTE), ('stop', Motion.COMING_TO_REST), ('goto 3', Motion.MOVED),
    ('emergency', Motion.COMING_TO_REST), ('order', Motion.COMING_TO_REST)])
def test_the_bridge_reports_it(event: Optional[str], motion: Motion):
    bench = Bench(yard(), 1)
    bench.order(7, 1, 5)
    bench.drive(4.0)
    if event == 'emergency':
        bench.tell(*bench.robot.press_emergency_stop())
        bench.press(True)
    elif event == 'order':
        bench.order(8)
    elif event == 'stop':
        bench.epoch += 1
        bench.robot.obey(None, 'stop')
        bench.tell(p.MotionTold(bench.epoch, cause=p.EpochCause.STOP))
    elif event:
        bench.overrule(command=event)
    assert bench.follower.report().motion is motion
    bench.drive(20.0)
    assert bench.follower.report().motion is Motion.STANDING
