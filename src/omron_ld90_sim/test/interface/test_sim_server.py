"""The lines for each client, the outgoing link, and dropped clients; without sockets."""
from __future__ import annotations

from sim_builders import Client, Rig

from omron_ld90_sim.interface.autonomy import Autonomy
from omron_ld90_sim.interface.outgoing import OutgoingLink


def test_a_reply_goes_to_the_asker_only() -> None:
    rig = Rig()
    first, second = rig.client(), rig.client()
    first.send('oneLineStatus', 'gooto 12', 'goto 99')
    assert len(first.lines()) == 4 and second.lines() == []


def test_events_go_to_everybody_who_is_logged_in_and_to_the_outgoing_link() -> None:
    rig = Rig()
    asker, other = rig.client(), rig.client()
    link = Client(rig, rig.server.connect_outgoing())
    stranger = rig.server.connect()
    stranger.output.clear()
    asker.send('goto west', 'stop')
    events = ['Going to West', 'Interrupted: Going to West', 'Stopping']
    asker.until('Stopped')
    assert other.lines()[:3] == events and link.lines()[:3] == events
    assert not stranger.output


def test_a_robot_that_is_switched_off_ends_every_connection_without_a_word() -> None:
    rig = Rig()
    client, stranger = rig.client(), Client(rig, rig.server.connect())
    client.send('shutDown')
    assert client.lines() == [] and client.session.closed
    assert stranger.lines() == ['Enter password:'] and stranger.session.closed
    assert not rig.server.online


def test_everybody_hears_that_the_server_shuts_down_the_stranger_at_the_prompt_too() -> None:
    rig = Rig()
    client, stranger = rig.client(), Client(rig, rig.server.connect())
    rig.server.shut_down()
    assert client.lines()[-1] == 'Shutting down server' and client.session.closed
    assert stranger.lines() == ['Enter password:', 'Shutting down server']
    assert stranger.session.closed


def test_the_outgoing_link_needs_no_login_and_takes_commands() -> None:
    rig = Rig()
    link = Client(rig, rig.server.connect_outgoing())
    assert link.ask('queryMotors') == ['Motors enabled']


def test_command_lists_run_at_their_own_intervals_without_drift() -> None:
    rig = Rig()
    for n, (seconds, commands) in enumerate([(0.5, 'queryMotors | echo'), (3, 'odometer')], 1):
        rig.server.configuration.set('Outgoing ARCL commands', f'OutgoingCommands{n}', commands)
        rig.server.configuration.set('Outgoing ARCL commands', f'OutgoingCommands{n}Seconds',
                                     seconds)
    link = Client(rig, rig.server.connect_outgoing())
    OutgoingLink(rig.server, link.session)
    rig.clock.advance(600.25)
    lines = link.lines()
    assert lines.count('Motors enabled') == lines.count('Echo is off.') == 1200
    odometers = [line for line in lines if line.startswith('Odometer')]
    assert len(odometers) == 200 and odometers[-1] == 'Odometer: 0 mm 0 deg 600 sec'


def test_status_lines_are_sent_at_their_interval() -> None:
    rig = Rig()
    rig.server.configuration.set('Outgoing ARCL connection setup', 'SendStatusInterval', 10)
    link = Client(rig, rig.server.connect_outgoing())
    OutgoingLink(rig.server, link.session)
    rig.clock.advance(1.05)
    assert len(link.lines()) == 10, 'the interval must be at least 100 ms'


def test_a_silent_listener_is_left_after_the_timeout() -> None:
    rig = Rig()
    rig.server.configuration.set('Outgoing ARCL connection setup', 'OutgoingSocketTimeoutInMins',
                                 '0.01')
    link = Client(rig, rig.server.connect_outgoing())
    OutgoingLink(rig.server, link.session)
    rig.clock.advance(4.5)
    link.send('')
    rig.clock.advance(9.0)
    assert not link.session.closed, 'a newline must keep the connection open'
    rig.clock.advance(11.0)
    assert link.session.closed


def test_a_silent_client_is_dropped_after_a_minute_at_the_earliest() -> None:
    rig = Rig()
    client = rig.client()
    rig.server.configuration.set('ARCL server setup', 'SessionTimeoutMins', '0.1')
    rig.clock.advance(50.0)
    client.send(' ')
    rig.clock.advance(105.0)
    assert not client.session.closed
    rig.clock.advance(130.0)
    assert client.session.closed


def test_without_its_required_link_the_robot_stands() -> None:
    rig = Rig()
    Autonomy(rig.server)
    rig.server.configuration.set('Outgoing ARCL connection setup', 'RequireConnectionToPathPlan',
                                 'true')
    client = rig.client()
    link = rig.server.connect_outgoing()
    client.send('goto 12')
    rig.clock.advance(2.0)
    assert client.lines() == ['Going to 12']
    link.close()
    assert client.until('Stopped') == ['Interrupted: Going to 12', 'Stopping', 'Stopped']
    assert client.ask('goto 12')[1] == ('CommandErrorDescription: Driving blocked by '
                                        'OutgoingARCLConnLost')
