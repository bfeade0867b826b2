"""Tasks by themselves, in lists and during a drive: their effects and their lines."""
from __future__ import annotations

import pytest
from sim_builders import Rig

from omron_ld90_sim.behaviour import tasks
from omron_ld90_sim.motion.space import Disc

JAM = 'Fault_Driving_Application jam "Jam" "Too sweet" true false true'


def test_a_task_can_send_a_text_to_everybody() -> None:
    rig = Rig()
    asker, other = rig.client(), rig.client()
    task = 'ARCLSendText "Entering room, please stand clear."'
    assert asker.ask(f'doTaskInstant {task}') == [
        'Entering room, please stand clear.', f'Completed doing instant task {task}']
    assert other.lines() == ['Entering room, please stand clear.']


def test_a_task_can_raise_and_clear_a_fault() -> None:
    client = Rig().client()
    assert client.ask('doTaskInstant applicationFaultSet jam "Jam" "Too sweet" true') == [
        f'Fault: {JAM}',
        'Completed doing instant task applicationFaultSet jam "Jam" "Too sweet" true']
    assert client.ask('goto 12')[-1] == 'CommandErrorDescription: Driving blocked by jam'
    assert client.ask('doTaskInstant applicationFaultClear jam') == [
        f'FaultCleared: {JAM}', 'Stopping',
        'Completed doing instant task applicationFaultClear jam']
    assert client.ask('faultsGet') == ['End of FaultList']


def test_a_task_can_switch_an_output_that_there_is() -> None:
    client = Rig().client()
    client.ask('doTaskInstant customOutputOn output_2')
    assert client.ask('outputQuery Output_2') == ['Output: Output_2 on']
    client.ask('doTaskInstant customOutputOff Output_2')
    assert client.ask('outputQuery Output_2') == ['Output: Output_2 off']
    assert client.ask('doTaskInstant customOutputOn lamp')[-1] == (
        "CommandErrorDescription: No output 'lamp'")
    client.send('listStart', 'listAdd customOutputOn lamp', 'listExecute')
    assert client.until('Error')[-1] == "Error: No output 'lamp'"


def test_a_robot_localizes_at_a_goal_in_an_instant() -> None:
    rig = Rig()
    client = rig.client()
    assert client.ask('doTaskInstant localizeAtGoal West 2000 180') == [
        'Completed doing instant task localizeAtGoal West 2000 180']
    assert not rig.robot.localization.lost
    assert client.ask('doTaskInstant localizeAtGoal "East side"') == [
        'Completed doing instant task localizeAtGoal "East side"']
    assert rig.robot.localization.lost
    assert client.ask('doTaskInstant localizeAtGoal moon')[-1] == (
        "CommandErrorDescription: No goal 'moon'")


@pytest.mark.parametrize('limit, fastest', [(300.0, 300.0), (0.0, 1350.0)])
def test_a_list_limits_the_speed_of_its_own_drives(limit: float, fastest: float) -> None:
    rig = Rig()
    client = rig.client()
    client.send('listStart', f'listAdd movementParametersTemp Normal {limit:g}',
                'listAdd goto 12', 'listExecute')
    speeds = []
    while rig.robot.activity:
        rig.clock.advance(rig.clock.next_time)
        speeds.append(rig.robot.base.speed)
    assert fastest * 0.7 < max(speeds) <= fastest + 1e-6


def test_a_speed_limit_lasts_until_it_is_lifted() -> None:
    rig = Rig()
    client = rig.client()
    fastest = {}
    for limit, goal in [(300, 'gotoPoint 0 2000'), (300, 'gotoPoint -3000 0'),
                        (0, 'gotoPoint 0 2000')]:
        client.ask(f'doTaskInstant movementParameters Normal {limit}')
        client.send(goal)
        speeds = []
        while rig.robot.activity:
            rig.clock.advance(rig.clock.next_time)
            speeds.append(rig.robot.base.speed)
        fastest[limit] = max(*speeds, fastest.get(limit, 0.0))
    assert fastest[300] <= 300.0 + 1e-6 < fastest[0], fastest


def test_a_wait_can_be_cancelled_by_a_task() -> None:
    client = Rig().client()
    client.send('doTask wait 10 "for parts" true', 'waitTaskState', 'doTaskInstant waitCancel')
    assert client.until('Completed doing task') == [
        'Will do task wait 10 "for parts" true', 'Doing task wait 10 "for parts" true',
        'WaitState: Waiting 10 seconds with status "for parts"',
        'WaitState: Waiting with status "for parts"', 'Completed doing instant task waitCancel',
        'WaitState: Waiting cancelled', 'Completed doing task wait 10 "for parts" true']


def test_speaking_takes_its_time() -> None:
    rig = Rig()
    client = rig.client()
    client.send('doTask say "a sentence of some length"')
    client.until('Completed')
    assert 1.0 < rig.clock.now < 5.0


@pytest.mark.parametrize('task', ['deltaHeading', 'goto', 'gotoPoint 1', 'say', 'wait soon',
                                  'movementParametersTemp 300', 'localizeAtGoal West far'])
def test_a_task_with_wrong_arguments_is_refused_before_it_begins(task: str) -> None:
    assert Rig().client().ask(f'doTask {task}') == [
        f'CommandError: doTask {task}', f"CommandErrorDescription: Bad arguments for task '{task}'"]


def test_a_turn_may_be_more_than_a_whole_one() -> None:
    rig = Rig()
    client = rig.client()
    client.send('doTask deltaHeading -1440 60')
    rig.clock.advance(10.0)
    assert rig.robot.base.rotation == pytest.approx(-60.0)
    client.until('Completed')
    assert rig.robot.base.turned == pytest.approx(1440.0, abs=0.1)
    assert rig.robot.pose.theta == pytest.approx(0.0, abs=0.1)


def test_a_move_ends_before_what_is_in_the_way_and_fails_there_after_a_while() -> None:
    rig = Rig()
    client = rig.client()
    client.send('doTask move 10000 300 200 50 5')
    lines = client.until('Error')
    assert lines[-1] == 'Error: Failed to move'
    wall = 1000.0 - rig.robot.navigation.floor.body.half_length
    assert rig.robot.pose.x == pytest.approx(wall - 200.0, abs=60.0)
    assert rig.clock.now == pytest.approx((rig.robot.pose.x + 3000.0) / 300.0 + 6.0, abs=1.5)


def test_a_move_goes_on_when_the_way_is_free_again() -> None:
    rig = Rig()
    client = rig.client()
    rig.robot.navigation.blocks.append(Disc(-1500.0, 0.0, 300.0))
    client.send('doTask move 2500')
    rig.clock.advance(10.0)
    assert rig.robot.base.still and rig.robot.pose.x < -2000.0
    rig.robot.navigation.blocks.clear()
    assert client.until('Completed')[-1] == 'Completed doing task move 2500'
    assert rig.robot.pose.x == pytest.approx(-500.0, abs=1.5)


def test_a_failed_macro_leaves_the_error_as_status() -> None:
    rig = Rig()
    client = rig.client()
    rig.robot.quirks.failing_goals.add('12')
    macro = tasks.macro(rig.robot, 'Tour', [tasks.parse('goto 12')])
    rig.robot.start(macro)
    client.until('Error: Failed going to goal')
    assert client.ask('status')[1] == 'Status: Error: Failed going to goal'


def test_a_docked_robot_that_is_told_to_stop_stays_docked() -> None:
    client = Rig(start=None).client()
    assert client.ask('stop') == ['Stopping', 'Stopped']
    extended, status, *_ = client.ask('status')
    assert extended == 'ExtendedStatusForHumans: Docked'
    assert status.startswith('Status: DockingState: Docked')
