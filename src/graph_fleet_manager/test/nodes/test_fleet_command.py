"""The command `fleet` prints the state of each robot, and declares robots absent."""
from __future__ import annotations

import json
import math

import genpy
import pytest

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.waits import WaitCode
from graph_fleet_manager.commands import fleet
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, WRONG, CommandProblem
from graph_fleet_manager.commands.fleet_client import name_problem
from graph_fleet_manager.commands.mission_names import MissionName
from graph_fleet_manager.commands.tables import as_json
from itrci_nav_msgs.msg import FleetRobot, FleetState, FleetStop, SymbolicPose
from itrci_nav_msgs.srv import ChargeRobot, DeclareAbsent, SetLoad
from trajectory_graph import Edge, Graph, Vertex, split_edges


@pytest.mark.parametrize('state', RobotState)
def test_every_state_has_its_word(state):
    robot = FleetRobot(name='a', type='agv', state=int(state),
                       outage_code=FleetRobot.OUTAGE_SILENT)
    line = fleet._listed(FleetState(robots=[robot]), None).splitlines()[1]
    assert line.split('agv')[1].strip().startswith(state.words)


@pytest.mark.parametrize('waits_for, word', [
    (WaitCode.NOTHING, 'driving'), (WaitCode.TRAFFIC, 'driving'), (WaitCode.STEP, 'working')])
def test_a_robot_at_a_step_works(waits_for, word):
    robot = FleetRobot(name='a', type='agv', state=FleetRobot.BUSY, waits_for_code=waits_for)
    line = fleet._listed(FleetState(robots=[robot]), None).splitlines()[1]
    assert line.split('agv')[1].strip().startswith(word)


def test_below_its_row_it_says_how_each_robot_without_work_comes_back():
    robots = [FleetRobot(name='a'), FleetRobot(
        name='b', state=FleetRobot.TAKEN_OVER, outage_code=FleetRobot.OUTAGE_TOO_NEAR,
        waits_for='it is too near')]
    assert fleet._listed(FleetState(robots=robots), None).splitlines()[3:] == [
        '    It is too near. When they are apart, bring it back with `fleet in b`.']


@pytest.mark.parametrize(('edge', 'place'), [(10, 'edge 7 at 50 %'), (-11, 'edge -7 at 17 %')])
def test_a_robot_on_a_section_is_listed_on_the_drawn_edge(edge, place):
    graph = split_edges(Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0)],
                              [Edge(7, 1, 2), Edge(8, 2, 1)]), 2.0)
    robots = [FleetRobot(name='a', pose=SymbolicPose(edge, 50.0))]
    assert place in fleet._listed(FleetState(robots=robots), graph)
    assert f'edge {edge} at 50 %' in fleet._listed(FleetState(robots=robots), None)


def test_a_robot_at_the_end_of_an_edge_is_listed_at_its_vertex():
    graph = Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0)], [Edge(7, 1, 2)])
    for edge, percentage, vertex in ((7, 100.0, 2), (-7, 100.0, 1), (7, 0.0, 1)):
        robots = [FleetRobot(name='a', pose=SymbolicPose(edge, percentage))]
        assert f'vertex {vertex} ' in fleet._listed(FleetState(robots=robots), graph)


STOP = FleetStop(FleetStop.PERSON, 'anna@desk (fleet)', genpy.Time(1000), '')


def test_a_stopped_fleet_is_told_first():
    lines = fleet._listed(FleetState(robots=[FleetRobot(name='a')], stop=STOP), None).splitlines()
    assert lines[0].startswith('The fleet is stopped since 1970')
    assert lines[0].endswith('by anna@desk (fleet). `fleet resume` lets it go on.')
    assert lines[1].startswith('robot')


LONG = 'a_robot_of_the_long_hall_17'


@pytest.mark.parametrize('robot', [
    FleetRobot(name=LONG, type=LONG, state=FleetRobot.OUT_OF_SERVICE, has_mission=True,
               request_id=2 ** 31 - 1, destination=123456, pose=SymbolicPose(-123456, 55.0),
               battery=1.0, waits_for=LONG * 20),
    FleetRobot(name=LONG, type=LONG, state=FleetRobot.OFFLINE, seen=genpy.Time(1),
               outage_code=FleetRobot.OUTAGE_SILENT, pose=SymbolicPose(1, 50.0))])
def test_the_table_fits_a_terminal(robot, monkeypatch):
    monkeypatch.setattr(fleet.rospy.Time, 'now', lambda: genpy.Time(100_000_000))
    listed = fleet._listed(FleetState(robots=[robot, FleetRobot(name='b')]), None)
    assert max(map(len, listed.splitlines())) <= 100
    assert listed.splitlines()[1].startswith(LONG[:8])


def test_programs_get_all_fields_as_json():
    robot = FleetRobot(name=LONG, type='agv', state=FleetRobot.BUSY, has_mission=True, request_id=7,
                       pose=SymbolicPose(-7, 25.0), seen=genpy.Time(5), battery=math.nan,
                       destination=3, to_destination=12.0, to_end=math.nan,
                       waits_for_code=WaitCode.TRAFFIC, waits_for='b', software='own 2.1')
    told = json.loads(as_json(fleet._values(FleetState(robots=[robot], stop=STOP), None)))
    assert told == {
        'stop': {'cause': 'PERSON', 'by': 'anna@desk (fleet)', 'since': 1000.0, 'why': ''},
        'robots': [{'robot': LONG, 'type': 'agv', 'software': 'own 2.1', 'state': 'BUSY',
                    'outage': None, 'edge': -7, 'fraction': 0.25,
                    'place': 'edge -7 at 25 %', 'seen': 5.0, 'battery': None, 'mission': 7,
                    'destination': 3, 'to_destination': 12.0, 'to_end': None,
                    'waits_for_code': 'TRAFFIC', 'waits_for': 'b'}]}
    assert fleet._values(FleetState(), None) == {'stop': None, 'robots': []}


@pytest.fixture
def called(monkeypatch):
    """Returns the services that were called.

    Robot `gone` is no longer in the fleet file; robot `near` reports.
    """
    called = []

    def call(service, kind, *arguments):
        if kind in (SetLoad, ChargeRobot):
            called.append((service, *arguments[:-1]))
            return 'done'
        assert kind is DeclareAbsent
        called.append(service)
        if service.startswith('/near/'):
            raise CommandProblem('near reports: switch it off first', NOT_DONE)
        return 'done'
    monkeypatch.setattr(fleet, 'connect', lambda name: None)
    monkeypatch.setattr(fleet, 'call', call)
    monkeypatch.setattr(fleet, '_robots', lambda: [
        FleetRobot(name='a', state=FleetRobot.UNKNOWN), FleetRobot(name='b'),
        FleetRobot(name='c', state=FleetRobot.UNKNOWN),
        FleetRobot(name='d', state=FleetRobot.OFFLINE),
        FleetRobot(name='near'), FleetRobot(name='gone', state=FleetRobot.OUT_OF_SERVICE)])
    return called


def test_robots_are_declared_absent_also_those_of_before(called):
    assert fleet._fleet(['absent', 'b', 'gone']) == OK
    assert called == ['/b/declare_absent', '/gone/declare_absent']


def test_all_robots_that_were_never_heard_of_are_declared_absent(called):
    assert fleet._fleet(['absent', '--unseen']) == OK
    assert called == ['/a/declare_absent', '/c/declare_absent']


def test_a_robot_that_cannot_be_absent_does_not_keep_the_others(called, capsys):
    assert fleet._fleet(['absent', 'near', 'wrong', 'b']) == NOT_DONE
    assert called == ['/near/declare_absent', '/b/declare_absent']
    said = capsys.readouterr().err
    assert 'switch it off first' in said and "There is no robot 'wrong'; there are: a, b" in said


@pytest.mark.parametrize('load, said', [('empty', (False, 0)), ('7', (True, 7))])
def test_a_person_says_what_a_robot_carries(called, load, said):
    assert fleet._fleet(['load', 'b', load]) == OK
    assert called == [('/b/set_load', *said)]


@pytest.mark.parametrize(('robot', 'told'), [
    (FleetRobot(name='b', state=FleetRobot.BUSY, has_mission=True, request_id=7, until=12.4,
                waits_for='its turn at station press, after a', waits_for_code=16),
     'b serves mission 7. It waits for: its turn at station press, after a, for about '
     '12 s.'),
    (FleetRobot(name='b', until=math.nan),
     'b is idle. It waits for nothing: it has nothing to do.'),
    (FleetRobot(name='b', state=FleetRobot.BUSY, has_mission=True, request_id=7, until=math.nan),
     'b serves mission 7. It waits for nothing: it drives, or may set out.')])
def test_it_says_what_a_robot_waits_for_and_until_when(called, monkeypatch, capsys, robot, told):
    monkeypatch.setattr(fleet, '_robots', lambda: [robot])
    assert fleet._fleet(['why', 'b']) == OK
    assert ' '.join(capsys.readouterr().out.split()) == told


def test_programs_get_what_a_robot_waits_for_as_json(called, monkeypatch, capsys):
    robot = FleetRobot(name='b', waits_for='a charger: dock_6 (a)', waits_for_code=12,
                       until=math.nan)
    monkeypatch.setattr(fleet, '_robots', lambda: [robot])
    assert fleet._fleet(['why', 'b', '--json']) == OK
    assert json.loads(capsys.readouterr().out) == {
        'robot': 'b', 'state': 'IDLE', 'mission': None, 'code': 'CHARGING',
        'waits_for': 'a charger: dock_6 (a)', 'until': None}


def test_why_a_robot_waits_is_asked_of_robots_that_there_are(called):
    with pytest.raises(CommandProblem, match="There is no robot 'x'"):
        fleet._fleet(['why', 'x'])


@pytest.mark.parametrize('words, until', [([], 0.8), (['--until', '95'], 0.95), (['--end'], 0.0)])
def test_a_robot_is_asked_to_charge(called, words, until):
    assert fleet._fleet(['charge', 'b', *words]) == OK
    assert called == [('/b/charge', until)]


@pytest.mark.parametrize('until', ['0', '101', 'nan'])
def test_no_robot_charges_beyond_what_it_can(called, until):
    with pytest.raises(SystemExit) as end:
        fleet._fleet(['charge', 'b', '--until', until])
    assert end.value.code == WRONG and not called


def test_a_person_names_the_mission_of_a_load_by_its_short_name(called, monkeypatch):
    monkeypatch.setattr(fleet, 'request_id', lambda name: 7 if name == MissionName(42, True) else 0)
    assert fleet._fleet(['load', 'b', 'M42']) == OK
    assert called == [('/b/set_load', True, 7)]


@pytest.mark.parametrize('words', [['b'], ['b', 'full'], ['b', '3000000000']])
def test_a_load_is_nothing_or_that_of_a_mission(called, words):
    with pytest.raises(SystemExit) as end:
        fleet._fleet(['load', *words])
    assert end.value.code == WRONG and not called


@pytest.mark.parametrize('arguments', [[], ['a', '--unseen']])
def test_which_robots_are_absent_must_be_said(called, arguments):
    with pytest.raises(SystemExit) as end:
        fleet._fleet(['absent', *arguments])
    assert end.value.code == WRONG and not called


@pytest.mark.parametrize(('host', 'expected'), [
    ('localhost', ''), ('127.0.0.1', ''),
    ('no-such-computer.invalid', "This computer's own name, no-such-computer.invalid, has no")])
def test_a_computer_whose_name_has_no_address_is_told(host, expected):
    """Subscribers connect to a publisher by this name. If it has no address, nothing arrives."""
    assert name_problem(host).startswith(expected)
    assert bool(name_problem(host)) == bool(expected)
