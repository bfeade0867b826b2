"""Faults on demand; each test states the effect of one fault."""
from __future__ import annotations

import pytest
from sim_builders import Client, Rig

from omron_ld90_sim.interface.autonomy import Autonomy
from omron_ld90_sim.interface.faults import Faults, NoSuchFault, help_text, run_script


class Faulty(Rig):
    """A rig with faults and a client."""

    def __init__(self, **arguments: object) -> None:
        super().__init__(**arguments)
        self.faults = Faults(self.server)
        self.me = self.client()

    def on_the_way(self, command: str = 'goto "East side"', seconds: float = 4.0) -> Client:
        """Lets the robot drive for a while. Returns the client."""
        self.me.send(command)
        self.clock.advance(self.clock.now + seconds)
        self.me.lines()
        assert self.robot.base.speed > 0.0
        return self.me


def test_the_emergency_stop_ends_the_drive_and_motors_stay_off_after_its_release() -> None:
    rig = Faulty()
    me = rig.on_the_way()
    rig.faults.inject('estop press')
    assert me.lines() == ['EStop pressed']
    rig.clock.advance(rig.clock.now + 2.0)
    assert rig.robot.base.still
    assert me.ask('enableMotors', 'queryMotors', 'goto 12') == [
        'Estop pressed cannot enable motors', 'EStop pressed', 'CommandError: goto 12',
        'CommandErrorDescription: EStop pressed']
    rig.faults.inject('estop release')
    assert me.ask('queryMotors') == ['EStop relieved but motors still disabled']
    me.send('enableMotors')
    assert me.until('Motors are') == ['Motors enabled', 'Stopping', 'Stopped', 'Motors are enabled']
    rig.clock.advance(rig.clock.now + 60.0)
    assert me.lines() == [], 'the goal must not be resumed'


def test_motors_off_without_the_button() -> None:
    rig = Faulty()
    rig.faults.inject('motors off')
    assert rig.me.lines() == ['Motors disabled']
    other = rig.client()
    rig.me.send('enableMotors')
    events = ['Motors enabled', 'Stopping', 'Stopped']
    assert rig.me.lines() == [*events, 'Motors are enabled']
    assert other.lines() == events


def test_a_robot_that_is_pushed_stands_there_and_drives_on_once_its_motors_are_on() -> None:
    rig = Faulty()
    me = rig.on_the_way()
    place = rig.robot.true_pose
    rig.faults.inject(f'push {place.x - 100:.0f} {place.y:.0f} 90')
    assert me.lines() == ['Motors disabled']
    rig.clock.advance(rig.clock.now + 5.0)
    assert f'Location: {place.x - 100:.0f} {place.y:.0f} 90' in me.ask('status')
    me.send('enableMotors')
    me.until('Motors are enabled')
    me.send('goto 12')
    me.until('Arrived at 12')


def test_a_robot_that_is_pushed_out_of_its_dock_is_not_docked() -> None:
    rig = Faulty()
    rig.me.send('dock')
    rig.me.until('DockingState: Docked')
    rig.faults.inject('push 0 0')
    assert any('DockingState: Undocked' in line for line in rig.me.lines())


def test_a_lost_robot_reports_a_wrong_place_until_it_is_localized() -> None:
    rig = Faulty()
    me = rig.on_the_way()
    rig.faults.inject('lost 3000 0 90')
    assert me.lines() == ['Error: Robot lost']
    rig.clock.advance(rig.clock.now + 5.0)
    true = rig.robot.true_pose
    lines = me.ask('status')
    assert 'Status: Robot lost' in lines
    assert f'Location: {round(true.x + 3000)} {round(true.y)} {round(true.theta + 90)}' in lines
    assert float(lines[4].split()[1]) < 0.2
    me.send(f'localizeToPoint {true.x:.0f} {true.y:.0f} {true.theta:.0f}')
    me.until('Localized')
    score = float(me.ask('status')[4].split()[1])
    assert score > 0.7
    me.send('goto 12')
    me.until('Arrived at 12')


def test_localizing_at_a_place_where_the_robot_is_not_leaves_it_lost() -> None:
    rig = Faulty()
    rig.me.send('localizeToPoint 4000 2000 0')
    rig.me.until('Localized')
    assert 'Status: Robot lost' in rig.me.ask('status')


def test_a_block_on_the_way_is_driven_around() -> None:
    rig = Faulty()
    me = rig.on_the_way()
    rig.faults.inject('block')
    me.until('Arrived at East side')


def test_a_goal_shut_in_fails_after_a_while_with_the_robots_words() -> None:
    rig = Faulty()
    rig.faults.inject('block 4500 1500 600')
    rig.me.send('goto "East side"')
    assert rig.me.until('Error') == ['Going to East side', 'Error: Failed going to goal']
    assert 'Status: Failed going to East side' in rig.me.ask('status')
    rig.faults.inject('unblock')
    rig.me.send('goto "East side"')
    rig.me.until('Arrived at East side')


def test_an_obstacle_that_goes_away_in_time_delays_only() -> None:
    rig = Faulty()
    rig.faults.inject('block 4500 1500 600')
    rig.me.send('goto "East side"')
    rig.clock.advance(rig.clock.now + 20.0)
    rig.faults.inject('unblock')
    assert rig.me.until('Arrived') == ['Going to East side', 'Arrived at East side']


def test_a_goal_that_fails_until_it_is_mended() -> None:
    rig = Faulty()
    rig.faults.inject('fail "East side"')
    rig.me.send('goto "East side"')
    assert rig.me.until('Error') == ['Going to East side', 'Error: Failed going to goal']
    rig.faults.inject('mend East side')
    rig.me.send('goto "East side"')
    rig.me.until('Arrived')


def test_a_robot_that_misses_the_charger_backs_out_and_docks_at_the_second_attempt() -> None:
    rig = Faulty()
    rig.faults.inject('faildock')
    rig.me.send('dock')
    states = [line.split()[1] for line in rig.me.until('DockingState: Docked')]
    assert states == ['Undocked', 'Docking', 'Undocking', 'Undocked', 'Docking', 'Docking',
                      'Docked']


def test_a_low_battery_warns_once_a_minute_and_sends_the_robot_to_its_dock() -> None:
    rig = Faulty()
    Autonomy(rig.server)
    rig.faults.inject('battery 20')
    rig.clock.advance(119.5)
    assert rig.me.lines() == ['TextRequestChargeVoltage'] * 2
    rig.faults.inject('autodock on')
    rig.me.until('DockingState: Docked')


def test_an_empty_robot_says_so_and_goes_off_until_it_is_charged_and_started() -> None:
    rig = Faulty()
    Autonomy(rig.server)
    me = rig.on_the_way()
    rig.faults.inject('battery 0')
    rig.clock.advance(rig.clock.now + 1.0)
    fault, farewell = me.lines()
    assert fault.startswith('Fault: Fault_Critical UnderVoltage "') and me.session.closed
    assert farewell == 'Shutting down server' and not rig.server.online
    rig.faults.inject('battery 60')
    rig.faults.inject('reboot 3')
    rig.clock.advance(rig.clock.now + 4.0)
    me = rig.client()
    me.send('goto 12')
    me.until('Arrived at 12')


def test_an_idle_robot_docks_by_itself_and_leaves_when_it_is_full() -> None:
    rig = Faulty(battery=99.0)
    Autonomy(rig.server)
    rig.faults.inject('autodock on')
    rig.clock.advance(14 * 60.0)
    assert rig.me.lines() == []
    rig.me.until('DockingState: Docked', seconds=300.0)
    rig.me.until('DockingState: Undocked', seconds=3600.0)


def test_another_client_drives_and_everybody_sees_it() -> None:
    rig = Faulty()
    me = rig.on_the_way('goto 12')
    rig.faults.inject('other goto West')
    assert me.lines() == ['Interrupted: Going to 12', 'Going to West']


def test_a_half_line_is_completed_later() -> None:
    rig = Faulty()
    rig.faults.inject('halfline 2')
    rig.me.send('queryMotors', 'echo')
    assert bytes(rig.me.session.output) == b'Motors e'
    rig.clock.advance(rig.clock.now + 2.0)
    assert bytes(rig.me.session.output) == b'Motors enabled\r\nEcho is off.\r\n'


def test_silence_holds_everything_back_for_a_while() -> None:
    rig = Faulty()
    rig.faults.inject('silence 5')
    rig.me.send('queryMotors')
    rig.clock.advance(4.9)
    assert rig.me.lines() == []
    rig.clock.advance(5.0)
    assert rig.me.lines() == ['Motors enabled']


def test_delayed_lines_keep_their_order() -> None:
    rig = Faulty()
    rig.faults.inject('delay 1')
    rig.me.send('queryMotors')
    rig.faults.inject('delay 0')
    rig.me.send('echo')
    assert rig.me.lines() == []
    rig.clock.advance(1.0)
    assert rig.me.lines() == ['Motors enabled', 'Echo is off.']


def test_a_wrong_prompt_greets_new_clients() -> None:
    rig = Faulty()
    rig.faults.inject('prompt login as:')
    assert bytes(rig.server.connect().output) == b'login as:\r\n'
    rig.faults.inject('prompt')
    assert bytes(rig.server.connect().output) == b'Enter password:\r\n'


@pytest.mark.parametrize('fault, aborted', [('drop', False), ('reset', True), ('reboot', True)])
def test_connections_end(fault: str, aborted: bool) -> None:
    rig = Faulty()
    rig.faults.inject(fault)
    assert rig.me.session.closed and rig.me.session.aborted is aborted
    assert rig.server.sessions == []


def test_a_reboot_takes_the_robot_away_for_a_while() -> None:
    rig = Faulty()
    rig.on_the_way()
    rig.faults.inject('reboot 3')
    assert not rig.server.online
    rig.clock.advance(rig.clock.now + 3.0)
    assert rig.server.online and rig.robot.base.still and rig.robot.activity is None


def test_nothing_runs_during_a_reboot_and_the_button_stays_pressed() -> None:
    rig = Faulty()
    Autonomy(rig.server)
    rig.faults.inject('estop press')
    rig.faults.inject('reboot 10')
    for fault in ('estop release', 'other enableMotors', 'battery 10', 'autodock on'):
        rig.faults.inject(fault)
    rig.clock.advance(9.0)
    assert rig.robot.activity is None
    rig.faults.inject('estop press')
    rig.clock.advance(11.0)
    assert rig.client().ask('status')[1] == 'Status: EStop pressed'


def test_a_robot_restarted_in_its_dock_is_docked() -> None:
    rig = Faulty(start=None)
    rig.faults.inject('reboot 3')
    rig.clock.advance(4.0)
    assert rig.client().ask('status')[1].startswith('Status: DockingState: Docked')


def test_a_goal_in_a_wall_fails_at_once_whatever_stands_around() -> None:
    rig = Faulty()
    rig.faults.inject('block 4500 -2000 300')
    assert rig.me.ask('gotoPoint 1000 0') == ['Going to point', 'Error: Failed going to goal']


def test_a_robot_kept_out_of_its_dock_never_says_docked() -> None:
    rig = Faulty(start=(-2000.0, -2000.0, 180.0))
    rig.me.send('dock')
    while rig.robot.extended != 'Driving into dock':
        rig.clock.advance(rig.clock.now + 0.1)
    rig.faults.inject('block -3250 -2000 250')
    lines = rig.me.until('Error')
    assert lines[-1] == 'Error: Failed going to goal'
    assert not [line for line in lines if line.startswith('DockingState: Docked')]
    assert 'Status: Failed going to dock at Dock 1' in rig.me.ask('status')


def test_a_robot_that_cannot_leave_its_dock_waits_and_goes_on() -> None:
    rig = Faulty(start=None)
    rig.faults.inject('block -1900 -2000 300')
    rig.me.send('goto 12')
    rig.clock.advance(20.0)
    assert 'Going to 12' not in rig.me.lines()
    rig.faults.inject('unblock')
    rig.me.until('Arrived at 12')


def test_a_script_brings_faults_at_their_times() -> None:
    rig = Faulty()
    run_script(['# first the button', '2 estop press', '', '4.5 estop release  # free'],
               rig.faults.schedule)
    rig.clock.advance(1.9)
    assert rig.me.lines() == []
    rig.clock.advance(2.0)
    assert rig.me.lines() == ['EStop pressed']
    rig.clock.advance(5.0)
    assert rig.me.lines() == ['EStop relieved but motors still disabled']


@pytest.mark.parametrize('words', ['', 'earthquake', 'estop', 'estop hit', 'battery low', 'delay',
                                   'drop all of them', 'fail', '5 earthquake', 'inject drop'])
def test_words_that_mean_no_fault_are_refused(words: str) -> None:
    with pytest.raises(NoSuchFault):
        Faulty().faults.schedule(words)


def test_a_script_names_the_line_that_is_wrong() -> None:
    with pytest.raises(NoSuchFault, match='line 2: '):
        run_script(['drop', '1 earthquake'], Faulty().faults.schedule)


def test_the_help_tells_of_every_fault() -> None:
    assert len(help_text().splitlines()) == 23
    assert 'estop press|release' in help_text()


def test_a_fault_that_proves_wrong_when_its_time_comes_is_told_and_ends_nothing(
        capsys: pytest.CaptureFixture) -> None:
    rig = Faulty()
    rig.faults.schedule('2 estop hammer')
    rig.clock.advance(3.0)
    assert "'estop hammer' is no fault, expected: estop press|release" in capsys.readouterr().err
    assert rig.me.ask('queryMotors') == ['Motors enabled']
