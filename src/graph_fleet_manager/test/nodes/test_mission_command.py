"""The command `mission` follows its own request, even if other messages have the same id."""
from __future__ import annotations

import argparse
import json
import time
from datetime import datetime

import genpy
import pytest
import rosgraph
import rospy
from fleet_builders import corridor

from fleet_core.supervision.history import HistoryLine
from fleet_core.supervision.mission_commands import not_done, not_stored
from fleet_core.supervision.missions import CommandKind, MissionState, RequestRefused, Status
from fleet_requests import NotSent
from graph_fleet_manager.commands import (
    fleet_client,
    mission,
    mission_names,
    place_names,
    timetables,
)
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, WRONG, CommandProblem
from graph_fleet_manager.commands.mission_names import mission_name
from graph_fleet_manager.messages.graphs import graph_message
from graph_fleet_manager.messages.missions import request_of, status_message
from itrci_nav_msgs.msg import (
    FleetResource,
    FleetState,
    MissionCommand,
    MissionDependency,
    MissionRequest,
    MissionStatus,
    MissionTemplate,
    MissionTemplates,
    RobotHindrance,
    StepParameter,
    Timetable,
    Timetables,
)
from itrci_nav_msgs.srv import ExplainMissionResponse, PauseTimetable

MINE, OTHER = 1.7e9 + 0.123456789, 1.7e9 - 60.0


class Told:
    """Statuses as they arrive on /mission_status, one by one."""

    def __init__(self, *statuses: MissionStatus) -> None:
        self.statuses = list(statuses)

    def wait(self, _: float) -> None:
        assert self.statuses, 'the command still waits after the last message'

    def unread(self):
        return [self.statuses.pop(0)] if self.statuses else []

    def publishers(self):
        return frozenset((1,))


class Nobody:
    """A topic without messages, or without subscribers."""

    def __init__(self, *_):
        self.published = []

    def unread(self):
        return []

    def send(self, message):
        self.published.append(message)

    repeat = send


@pytest.fixture(autouse=True)
def no_topics(monkeypatch):
    monkeypatch.setattr(mission, 'TopicListener', Nobody)
    for module in (mission, fleet_client):
        monkeypatch.setattr(module, 'connected_sender', Nobody)
    monkeypatch.setattr(mission, 'ask_for', lambda request: lambda: None)


def request(id: int = 7) -> MissionRequest:
    message = MissionRequest(request_id=id, destination_vertices_id=[3])
    message.header.stamp = rospy.Time.from_sec(MINE)
    return message


def status(state: MissionState, stamp: float = MINE, reason: str = '') -> MissionStatus:
    return status_message(Status(7, state, 'a', 1, reason, stamp), rospy.Time(5))


def test_an_older_mission_with_the_same_id_is_not_the_answer():
    told = Told(status(MissionState.ACTIVE, OTHER), status(MissionState.SUCCEEDED, OTHER),
                status(MissionState.REFUSED, MINE, 'mission 7 is open with other content'))
    answer = mission._acknowledged(request(), told)
    assert (answer.state, answer.reason) == (MissionStatus.REFUSED,
                                             'mission 7 is open with other content')


def test_the_end_of_an_older_mission_is_not_its_end(capsys):
    told = Told(status(MissionState.FAILED, OTHER), status(MissionState.ACTIVE),
                status(MissionState.CANCELLED, OTHER), status(MissionState.SUCCEEDED))
    assert mission._follow(request(), status(MissionState.PENDING), told, None) == OK
    assert 'Mission 7 has succeeded: a was at 3.' in capsys.readouterr().out


def test_its_own_end_is_told_with_the_reason():
    told = Told(status(MissionState.SUCCEEDED, OTHER), status(MissionState.FAILED, MINE, 'a: lost'))
    with pytest.raises(CommandProblem, match='FAILED: a: lost') as failed:
        mission._follow(request(), status(MissionState.PENDING), told, None)
    assert failed.value.status == NOT_DONE


def test_the_stamp_of_a_request_survives_the_way_through_the_fleet_manager():
    sent = request()
    known = request_of(sent)
    told = status_message(Status(known.id, MissionState.PENDING, stamp=known.stamp), rospy.Time(5))
    assert mission.is_about(told, sent)
    sent.header.stamp += rospy.Duration(0, 2000)
    assert not mission.is_about(told, sent)


def change(monkeypatch, word: str, *statuses: MissionStatus, more: tuple = ()) -> None:
    """Runs `mission WORD 7 MORE` while these statuses arrive."""
    monkeypatch.setattr(mission, 'connect', lambda name: None)
    monkeypatch.setattr(mission, 'TopicListener', lambda *_: Told(*statuses))
    monkeypatch.setattr('rospy.rostime.get_rostime', lambda: rospy.Time(5))
    more = more or (('--priority', '3') if word == 'modify' else ())
    mission._change(word, [word, '7', *more])


def test_what_is_told_of_other_missions_with_its_id_is_no_answer_to_a_command(monkeypatch, capsys):
    change(monkeypatch, 'cancel',
           status(MissionState.SUCCEEDED, OTHER), status(MissionState.ACTIVE),
           status(MissionState.REFUSED, OTHER, 'mission 7 is open with other content'),
           status(MissionState.CANCELLED, MINE, 'cancelled on request'))
    assert capsys.readouterr().out == 'Mission 7: CANCELLED: cancelled on request\n'


@pytest.mark.parametrize('word, last', [
    ('cancel', status_message(not_stored(
        Status(7, MissionState.ACTIVE, stamp=MINE), CommandKind.CANCEL, 'a full disk'),
        rospy.Time(5))),
    ('cancel', status(MissionState.SUCCEEDED)), ('pause', status(MissionState.PAUSED)),
    ('resume', status(MissionState.PENDING)), ('release', status(MissionState.ACTIVE)),
    ('modify', status(MissionState.ACTIVE)), ('cancel', status(MissionState.CANCELLING)),
    ('cancel', status(MissionState.NEEDS_PERSON))])
def test_the_first_status_that_shows_a_command_answers_it(monkeypatch, capsys, word, last):
    other = MissionState.PAUSED if word == 'resume' else MissionState.ACTIVE
    is_answered_at_once = word in ('release', 'modify')
    on_the_way = [] if is_answered_at_once else [status(other, MINE, 'a: it does not report')]
    change(monkeypatch, word, status(other), *on_the_way, last)
    assert MissionState(last.state).name in capsys.readouterr().out


def test_priority_and_destinations_are_changed_on_request_of_a_user(monkeypatch):
    sent = []
    monkeypatch.setattr(Nobody, 'send', lambda _, message: sent.append(message))
    change(monkeypatch, 'modify', status(MissionState.ACTIVE), status(MissionState.ACTIVE),
           more=('18', '39', '--priority', '-2'))
    assert sent[0].command == MissionCommand.MODIFY and sent[0].priority == -2
    assert list(sent[0].destination_vertices_id) == [18, 39] and '@' in sent[0].requested_by


@pytest.mark.parametrize('word', ['retry', 'skip', 'fail', 'done'])
def test_an_answer_is_for_the_step_that_asks_when_the_person_gives_it(monkeypatch, word):
    sent = []
    monkeypatch.setattr(Nobody, 'send', lambda _, message: sent.append(message))
    asks = status(MissionState.NEEDS_PERSON)
    asks.asks = 2 ** 60
    change(monkeypatch, 'answer', asks, status(MissionState.ACTIVE), more=(word,))
    assert (sent[0].command, sent[0].step_key) == (MissionCommand.ANSWER, 2 ** 60)
    assert sent[0].answer == getattr(MissionCommand, word.upper())


def test_a_change_that_is_refused_is_told_with_its_reason(monkeypatch):
    refused = status_message(not_done(Status(7, MissionState.ACTIVE, stamp=MINE),
                                      CommandKind.MODIFY, 'the graph has no vertex 99'),
                             rospy.Time(5))
    with pytest.raises(CommandProblem, match='7: MODIFY is not done: .* no vertex 99') as failed:
        change(monkeypatch, 'modify', status(MissionState.ACTIVE), refused)
    assert failed.value.status == NOT_DONE


@pytest.mark.parametrize('words', [
    ['18', '--id', '3000000000'], ['18', '--priority', '-3000000000'], ['why', '3000000000'],
    ['18', '--after', '3000000000'], ['cancel', '-3000000000']])
def test_a_number_that_no_message_can_hold_is_refused(words, capsys):
    with pytest.raises(SystemExit) as end:
        mission.main(words)
    assert end.value.code == WRONG
    assert 'is not from -2147483647 to 2147483647' in capsys.readouterr().err


def test_a_vertex_that_no_message_can_hold_is_refused():
    with pytest.raises(CommandProblem, match='the graph has no vertex 3000000000'):
        place_names.PlaceNames().destination('3000000000')


@pytest.mark.parametrize('word, state', [
    ('pause', MissionState.PAUSED), ('resume', MissionState.ACTIVE),
    ('resume', MissionState.PENDING)])
def test_a_mission_that_is_so_already_is_told_at_once(monkeypatch, capsys, word, state):
    """The fleet manager publishes only changes, so the command asks the fleet manager for the
    state."""
    asked = []
    monkeypatch.setattr(Nobody, 'send', lambda _, message: asked.append(message))
    change(monkeypatch, word, status(state))
    assert [message.request_id for message in asked] == [7]
    assert capsys.readouterr().out == f'Mission 7 is {state.name} already: nothing to {word}.\n'


def test_a_mission_comes_after_one_that_is_named_by_its_short_name(monkeypatch):
    sent, known = [], status(MissionState.ACTIVE)
    known.serial = 42
    monkeypatch.setattr(Nobody, 'send', lambda _, message: sent.append(message))
    monkeypatch.setattr(mission_names, 'open_mission',
                        lambda name, _: known if name.is_of(known) else None)
    monkeypatch.setattr(mission_names, 'TopicListener', lambda *_: None)
    found = mission._conditions(argparse.Namespace(
        type='', robot='', priority=0, id=None, not_before=None, before=None,
        after=[mission_name('M42')], after_end=[mission_name('5')]))
    assert [(one.request_id, one.until) for one in found['after']] == [
        (7, MissionDependency.DONE), (5, MissionDependency.ENDED)]


def test_the_history_has_the_short_name_first_in_the_table_and_last_as_csv(monkeypatch, capsys):
    monkeypatch.setattr(mission, 'history', lambda _: iter([HistoryLine(
        7, (4, 5), '', 0, MissionState.ACTIVE, 'a', 0, 1.0, 2.0, None, '', serial=42)]))
    mission.main(['history', '--journal', 'any'])
    assert capsys.readouterr().out.splitlines()[1].split()[:2] == ['M42', '7']
    mission.main(['history', '--journal', 'any', '--csv'])
    assert capsys.readouterr().out.splitlines()[1].endswith(',M42')


@pytest.mark.parametrize('is_online, runs, place', [
    (True, True, 'made_fleet'), (True, False, 'ros_home'), (False, False, 'ros_home')])
def test_history_is_that_of_the_fleet_manager_that_runs(
        monkeypatch, capsys, tmp_path, is_online, runs, place):
    """A simulated fleet keeps its journal in a folder without a fixed name."""
    class Master:
        def __init__(self, *_):
            pass

        def lookupNode(self, name):
            if name == '/path_supervisor' and runs:
                return 'http://127.0.0.1:1'
            raise rosgraph.MasterError('unknown node')

    files = {name: tmp_path / name / 'graph_fleet_manager' / 'fleet.sqlite'
             for name in ('made_fleet', 'ros_home')}
    monkeypatch.setenv('ROS_HOME', str(tmp_path / 'ros_home'))
    monkeypatch.setattr(rosgraph, 'is_master_online', lambda: is_online)
    monkeypatch.setattr(rosgraph, 'Master', Master)
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: {
        '/path_supervisor/journal': str(files['made_fleet'])}[name])
    assert mission.main(['history']) == 1
    assert f'There is no journal {files[place]}' in capsys.readouterr().err


@pytest.mark.parametrize('name, problem', [('a' * 257, 'more than 256 letters'),
                                           ('a\n', 'cannot be printed')])
@pytest.mark.parametrize('field', ['robot', 'robot_type'])
def test_a_request_that_names_what_is_no_name_is_refused(field, name, problem):
    message = request()
    setattr(message, field, name)
    with pytest.raises(RequestRefused, match=f'its {field} .*{problem}'):
        request_of(message)


def test_other_stops_are_sent_from_a_file(monkeypatch, tmp_path):
    (tmp_path / 'stops.yaml').write_text('stops:\n- {at: 5, steps: [{type: a, timeout: 9}]}')
    sent = []
    monkeypatch.setattr(Nobody, 'send', lambda _, message: sent.append(message))
    change(monkeypatch, 'modify', status(MissionState.ACTIVE), status(MissionState.ACTIVE),
           more=('--priority', '3', '--stops', str(tmp_path / 'stops.yaml')))
    one, = sent
    assert [stop.vertex for stop in one.stops] == [5] and one.stops[0].steps[0].type == 'a'


# -- names of places -----------------------------------------------------------------------------

SITE = {
    '/graph': graph_message(corridor(9), rospy.Time(1)),
    '/fleet_state': FleetState(resources=[
        FleetResource(name='press', kind=FleetResource.STATION, vertices=[3]),
        FleetResource(name='shelves', kind=FleetResource.STATION, vertices=[5, 6], is_group=True),
        FleetResource(name='table', kind=FleetResource.STATION, vertices=[7, 8]),
        FleetResource(name='gate', kind=FleetResource.DOOR)])}


@pytest.fixture
def site(monkeypatch):
    class Topic(Nobody):
        def __init__(self, topic, _):
            self.topic = topic

        def last(self):
            return SITE[self.topic]
    monkeypatch.setattr(place_names, 'TopicListener', Topic)


def test_vertices_stations_and_groups_are_destinations(site, monkeypatch):
    sent = Sent(monkeypatch)
    assert mission.main(['press', 'shelves', '18']) == 0
    assert [(stop.vertex, stop.group) for stop in sent.request.stops] == [
        (3, ''), (0, 'shelves'), (18, '')]
    assert not sent.request.destination_vertices_id
    assert mission.main(['press', '18', '--dwell', '4']) == 0
    assert list(sent.request.destination_vertices_id) == [3, 18] and not sent.request.stops
    assert request_of(sent.request).dwells == (4.0, 4.0)


@pytest.mark.parametrize('words, told', [
    (['pres'], "no station and no vertex is named 'pres'; the stations are: press, shelves, table"),
    (['gate'], "no station and no vertex is named 'gate'"),
    (['table'], 'station table is no group; give one of its places: 7, 8'),
    (['shelves', '--dwell', '4'], 'A group takes no stay')])
def test_a_word_that_names_no_one_place_is_refused_before_anything_is_sent(
        site, monkeypatch, capsys, words, told):
    sent = Sent(monkeypatch)
    assert mission.main(words) == 1
    assert told in capsys.readouterr().err and sent.request is None


def test_a_mission_may_be_changed_to_a_group(site, monkeypatch):
    sent = []
    monkeypatch.setattr(Nobody, 'send', lambda _, message: sent.append(message))
    change(monkeypatch, 'modify', status(MissionState.ACTIVE), status(MissionState.ACTIVE),
           more=('press', 'shelves', '--priority', '3'))
    assert [(stop.vertex, stop.group) for stop in sent[0].stops] == [(3, ''), (0, 'shelves')]


def test_a_file_of_stops_may_name_a_station_but_a_group_is_no_vertex(site, monkeypatch, tmp_path,
                                                                     capsys):
    file = tmp_path / 'stops.yaml'
    sent = Sent(monkeypatch)
    file.write_text('stops:\n- {at: press}\n- {group: shelves}')
    assert mission.main(['--stops', str(file)]) == 0
    assert [(stop.vertex, stop.group) for stop in sent.request.stops] == [(3, ''), (0, 'shelves')]
    file.write_text('stops:\n- {at: shelves}')
    assert mission.main(['--stops', str(file)]) == 1
    assert 'line 2: shelves is a group; write `group: shelves`' in capsys.readouterr().err


# -- templates ------------------------------------------------------------------------------------


class Sent:
    """Keeps the request that the command sends, and answers that the request is accepted."""

    def __init__(self, monkeypatch):
        monkeypatch.setattr(mission, 'connect', self.connect)
        monkeypatch.setattr(mission, '_send_request', self.take)
        monkeypatch.setattr(mission, 'requested_by', lambda program: 'a person')
        self.request = self.argv = None

    def connect(self, name, argv=None):
        self.argv = argv

    def take(self, request, waits, graph):
        self.request = request
        return 0


def test_a_template_is_sent_with_its_arguments_and_with_a_deadline_in_the_future(monkeypatch):
    sent, before = Sent(monkeypatch), time.time()
    assert mission.main(['run', 'pallet', 'from:=press', 'to:=a:=b', '--before', '14:30',
                         '--priority', '3']) == 0
    request = sent.request
    assert (request.template, request.priority) == ('pallet', 3)
    assert [(one.name, one.value) for one in request.arguments] == [
        ('from', 'press'), ('to', 'a:=b')]
    assert before < request.deadline.to_sec() <= before + 25 * 3600 and not request.earliest
    assert datetime.fromtimestamp(request.deadline.to_sec()).strftime('%H:%M') == '14:30'


def test_arguments_of_a_template_are_no_remappings_for_ros(monkeypatch):
    monkeypatch.setattr('sys.argv', ['mission', 'run', 'pallet', 'to:=39', '__name:=someone'])
    sent = Sent(monkeypatch)
    assert mission.main() == 0
    assert [(one.name, one.value) for one in sent.request.arguments] == [('to', '39')]
    assert sent.argv == ['mission', '__name:=someone']


@pytest.mark.parametrize('words, told', [
    (['pallet', 'to=39'], 'is not of the form NAME:=VALUE'),
    (['pallet', '--before', '24:10'], 'is no time of day'), ([], 'template')])
def test_wrong_words_about_a_template_are_refused(monkeypatch, capsys, words, told):
    sent = Sent(monkeypatch)
    with pytest.raises(SystemExit) as ended:
        mission.main(['run', *words])
    assert ended.value.code == 1
    assert told in capsys.readouterr().err and sent.request is None


def test_the_templates_are_listed(monkeypatch, capsys):
    class Templates(Nobody):
        def last(self):
            return MissionTemplates(templates=[MissionTemplate('pallet', ['from', 'to']),
                                               MissionTemplate('tour', [])])
    monkeypatch.setattr(mission, 'connect', lambda topic: None)
    monkeypatch.setattr(mission, 'TopicListener', Templates)
    assert mission.main(['templates']) == 0
    assert [line.split() for line in capsys.readouterr().out.splitlines()] == [
        ['template', 'parameters'], ['pallet', 'from', 'to'], ['tour', '-']]


# -- mission timetables ---------------------------------------------------------------------------


def test_the_timetables_are_listed_with_their_next_run(monkeypatch, capsys):
    class Listener(Nobody):
        def last(self):
            return Timetables(timetables=[
                Timetable(name='milk', template='pallet', arguments=[StepParameter('to', '39')],
                          every=30, begin=360, end=1080, days=list(range(5)),
                          next=genpy.Time.from_sec(datetime(2026, 11, 27, 6, 30).timestamp())),
                Timetable(name='night', template='tour', every=120, begin=1320, end=1680,
                          days=list(range(7)), is_paused=True)])
    monkeypatch.setattr(timetables, 'connect', lambda topic: None)
    monkeypatch.setattr(timetables, 'TopicListener', Listener)
    assert mission.main(['timetables']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].endswith('every 30 min, 06:00 to 18:00, mon tue wed thu fri  Fri 06:30')
    assert lines[2].split()[-2:] == ['04:00', 'paused'] and 'every 2 h, 22:00 to' in lines[2]


@pytest.mark.parametrize('word, paused', [('pause', True), ('resume', False)])
def test_a_timetable_is_paused_and_resumed(monkeypatch, word, paused):
    asked = []
    monkeypatch.setattr(timetables, 'connect', lambda topic: None)
    monkeypatch.setattr(timetables, 'call', lambda *request: asked.append(request) or 'done')
    assert mission.main(['timetables', word, 'milk']) == 0
    assert asked[0][:4] == ('/pause_timetable', PauseTimetable, 'milk', paused)


# -- mission why ----------------------------------------------------------------------------------


@pytest.fixture
def explained(monkeypatch):
    """Sets the answer of the fleet manager to `mission why`."""
    told = ExplainMissionResponse(
        found=True, state=MissionStatus.PENDING, waits_for_code=ExplainMissionResponse.ROBOT,
        waits_for='it waits for a robot to be free', until=41.6, robots=[
            RobotHindrance('a', RobotHindrance.BUSY, True, 5, 41.6, 'it serves mission 5'),
            RobotHindrance('b', RobotHindrance.OTHER_TYPE, False, 0, float('nan'),
                           'the mission is for another type of robot')])
    monkeypatch.setattr(mission, 'connect', lambda name: None)
    monkeypatch.setattr(mission, 'ask', lambda service, kind, id: told)
    return told


def test_why_names_what_a_mission_waits_for_and_the_reason_of_each_robot(explained, capsys):
    assert mission.main(['why', '7']) == OK
    assert capsys.readouterr().out.splitlines() == [
        'Mission 7 is PENDING. Reason: it waits for a robot to be free, for about 42 s.',
        'robot  why it does not serve the mission',
        'a      it serves mission 5, for about 42 s',
        'b      the mission is for another type of robot']


def test_why_of_a_mission_that_drives_says_so(explained, capsys):
    explained.robot, explained.state, explained.robots = 'a', MissionStatus.ACTIVE, []
    explained.waits_for, explained.until = '', float('nan')
    assert mission.main(['why', '7']) == OK
    assert capsys.readouterr().out == (
        'Mission 7 is ACTIVE, served by a. Reason: its robot drives, or sets out.\n')


def test_why_tells_programs_codes_and_numbers(explained, capsys):
    assert mission.main(['why', '7', '--json']) == OK
    told = json.loads(capsys.readouterr().out)
    assert (told['state'], told['code'], told['robot']) == ('PENDING', 'ROBOT', None)
    assert told['until'] == pytest.approx(41.6)
    busy, other = told['robots']
    assert (busy['hindrance'], busy['mission']) == ('BUSY', 5)
    assert other == {'robot': 'b', 'hindrance': 'OTHER_TYPE', 'mission': None, 'until': None,
                     'reason': 'the mission is for another type of robot'}


def test_why_of_a_mission_that_is_not_open_is_not_done(explained, capsys):
    explained.found = False
    assert mission.main(['why', '7']) == NOT_DONE
    assert 'There is no open mission 7' in capsys.readouterr().err


def test_a_fleet_manager_that_ends_before_it_is_told_is_named_in_one_line(capsys):
    def command(_: object) -> int:
        raise NotSent('No program takes commands: is path_supervisor running?')
    assert fleet_client.run('mission', command, []) == WRONG
    assert capsys.readouterr().err == (
        'mission: No program takes commands: is path_supervisor running?\n')
