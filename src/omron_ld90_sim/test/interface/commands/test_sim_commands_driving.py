"""Drives that start in the dock, are replaced, are stopped or fail; and patrols."""
from __future__ import annotations

import pytest
from sim_builders import Rig
from transcripts_driving import UNDOCKED

from omron_ld90_sim.interface.faults import Faults
from omron_ld90_sim.motion.space import Disc


def test_from_the_dock_goto_backs_out_first() -> None:
    client = Rig(start=None).client()
    client.send('goto 12')
    assert client.until('Arrived') == [
        'DockingState: Undocking ForcedState: Unforced ChargeState: Float',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Not',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Overcharge',
        'DockingState: Undocking ForcedState: Unforced ChargeState: Bulk',
        UNDOCKED, 'Going to 12', 'Arrived at 12']


def test_stopped_half_way_out_of_the_dock_the_robot_finds_its_way_on() -> None:
    rig = Rig(start=None)
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(1.0)
    client.send('stop')
    assert client.until('Stopped')[-4:] == [UNDOCKED, 'Interrupted: Going to 12', 'Stopping',
                                            'Stopped']
    client.send('goto 12')
    assert client.until('Arrived') == ['Going to 12', 'Arrived at 12']


@pytest.mark.parametrize('task', ['move 300', 'setHeading 90'])
def test_a_moving_task_leaves_the_dock_first(task: str) -> None:
    client = Rig(start=None).client()
    client.send(f'doTask {task}')
    lines = client.until('Completed')
    assert lines[-2:] == [UNDOCKED, f'Completed doing task {task}']


def test_a_dock_that_cannot_be_reached_leaves_the_robot_undocked() -> None:
    rig = Rig()
    rig.robot.navigation.blocks.append(Disc(-2500.0, -2000.0, 300.0))
    client = rig.client()
    client.send('dock')
    assert client.until('Error')[-2:] == [UNDOCKED, 'Error: Failed going to goal']


def test_a_second_goto_replaces_the_first() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto "East side"')
    rig.clock.advance(3.0)
    client.send('goto 12')
    assert client.until('Arrived') == ['Going to East side', 'Interrupted: Going to East side',
                                       'Going to 12', 'Arrived at 12']


def test_stop_on_the_way_tells_what_it_ended() -> None:
    rig = Rig()
    client = rig.client()
    client.send('goto 12')
    rig.clock.advance(4.0)
    moving = rig.robot.base.speed
    client.send('stop')
    assert client.until('Stopped') == ['Going to 12', 'Interrupted: Going to 12', 'Stopping',
                                       'Stopped']
    assert moving > 0.0 and rig.robot.base.speed == 0.0


def test_a_patrol_tells_nothing_of_the_goals_on_its_way() -> None:
    rig = Rig()
    client = rig.client()
    client.send('patrol Round')
    goals = {goal.name: goal for goal in rig.robot.document.goals}
    for name in ('West', 'East side', 'West', 'East side'):
        while rig.robot.extended == f'Going to {name}':
            assert rig.robot.status == 'Patrolling route Round'
            rig.clock.advance(rig.clock.next_time)
        assert rig.robot.true_pose.distance_to(goals[name].x, goals[name].y) < 50.0, name
    assert rig.robot.extended == 'Going to West'
    assert client.lines() == ['Patrolling route Round']


def test_a_stopped_patrol_is_resumed_at_the_goal_it_was_going_to() -> None:
    rig = Rig()
    client = rig.client()
    client.send('patrolOnce Round')
    while rig.robot.extended != 'Going to East side':
        rig.clock.advance(rig.clock.next_time)
    client.send('stop')
    assert client.until('Stopped')[1] == 'Interrupted: Patrolling route Round once'
    client.send('patrolResume Round')
    assert rig.robot.extended == 'Going to East side'
    assert client.until('Finished') == ['Patrolling route Round once',
                                        'Finished patrolling route Round']


def test_a_goal_of_a_patrol_that_cannot_be_reached_is_told() -> None:
    rig = Rig()
    rig.robot.quirks.failing_goals.add('east side')
    client = rig.client()
    client.send('patrolOnce Round')
    assert client.until('Error') == ['Patrolling route Round once', 'Error: Failed going to goal']
    assert client.ask('oneLineStatus')[0].startswith('Status: Failed going to East side ')


def test_a_patrol_from_the_dock_backs_out_and_says_that_it_patrols() -> None:
    rig = Rig(start=None)
    client = rig.client()
    client.send('patrolOnce Round')
    client.until(UNDOCKED)
    rig.clock.advance(rig.clock.now + 1.0)
    assert client.ask('status')[1] == 'Status: Patrolling route Round once'


def test_a_cleared_fault_lets_a_docked_robot_stay() -> None:
    client = Rig(start=None).client()
    lines = client.ask('afs jam "Jam" "Too sweet" 1 0', 'afc jam')
    assert 'Stopping' not in lines and lines[-1] == 'ApplicationFaultClear cleared jam'


def test_a_queued_drive_tells_its_end_and_an_interrupted_one_does_not() -> None:
    client = Rig().client()
    client.send('queueDropoff west 22 y4rt')
    done = client.until('QueueUpdate: DROPOFF1 y4rt 22 Completed')
    assert done[-2] == 'Arrived at West'
    client.ask('queueDropoff "East side"')
    client.send('stop')
    assert not [line for line in client.until('Stopped') if 'Completed' in line]


def test_undocked_stopping_and_stopped_come_apart_in_time() -> None:
    rig = Rig()
    client = rig.client()
    times = []
    client.send('undock')
    for line in ('DockingState: Undocked', 'Stopping', 'Stopped'):
        client.until(line)
        times.append(rig.clock.now)
    assert times[0] < times[1] < times[2]


def test_connect_outgoing_tells_its_success_only_when_the_connection_stands() -> None:
    rig = Rig()
    client = rig.client()
    assert client.ask('connectOutgoing 127.0.0.1 7179') == []
    rig.server.connect_outgoing()
    assert client.lines() == ['Outgoing connected to 127.0.0.1 7179']
    rig.server.connect_outgoing()
    assert client.lines() == []


def test_a_robot_that_parks_by_itself_says_so() -> None:
    rig = Rig()
    client = rig.client()
    Faults(rig.server).inject('park West')
    client.until('Parking')
    assert client.ask('oneLineStatus')[0].startswith('Status: Parking ')
    client.until('Parked')
    assert client.ask('oneLineStatus')[0].startswith('Status: Parked ')
