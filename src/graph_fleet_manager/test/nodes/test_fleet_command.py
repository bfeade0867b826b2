"""The command `fleet` prints the state of each robot, and declares robots absent."""
from __future__ import annotations

import pytest

from fleet_core.supervision.fleet_view import RobotState
from graph_fleet_manager.commands import fleet
from graph_fleet_manager.commands.command_line import NOT_DONE, OK, WRONG, CommandError
from graph_fleet_manager.commands.fleet_client import name_problem
from itrci_nav_msgs.msg import FleetRobot, FleetState, SymbolicPose
from itrci_nav_msgs.srv import DeclareAbsent, SetLoad
from trajectory_graph import Edge, Graph, Vertex, split_edges


@pytest.mark.parametrize('state', RobotState)
def test_every_state_has_its_word(state):
    robot = FleetRobot(name='a', type='agv', state=int(state),
                       outage_code=FleetRobot.OUTAGE_SILENT)
    line = fleet._listed(FleetState(robots=[robot]), None).splitlines()[1]
    assert line.split('agv')[1].strip().startswith(state.name.lower().replace('_', ' '))


def test_below_the_table_it_says_how_each_robot_without_work_comes_back():
    robots = [FleetRobot(name='a'), FleetRobot(
        name='b', state=FleetRobot.TAKEN_OVER, outage_code=FleetRobot.OUTAGE_TOO_NEAR)]
    assert fleet._listed(FleetState(robots=robots), None).splitlines()[3:] == [
        'b: When they are apart, bring it back with `fleet in b`.']


@pytest.mark.parametrize(('edge', 'place'), [(10, 'edge 7 at 50 %'), (-11, 'edge -7 at 17 %')])
def test_a_robot_on_a_section_is_listed_on_the_drawn_edge(edge, place):
    graph = split_edges(Graph([Vertex(1, 0.0, 0.0, 0.0), Vertex(2, 6.0, 0.0, 0.0)],
                              [Edge(7, 1, 2), Edge(8, 2, 1)]), 2.0)
    robots = [FleetRobot(name='a', pose=SymbolicPose(edge, 50.0))]
    assert place in fleet._listed(FleetState(robots=robots), graph)
    assert f'edge {edge} at 50 %' in fleet._listed(FleetState(robots=robots), None)


@pytest.fixture
def called(monkeypatch):
    """The called services. `gone` is no longer in the fleet file, `near` reports."""
    called = []

    def call(service, kind, *arguments):
        if kind is SetLoad:
            called.append((service, *arguments[:2]))
            return 'done'
        assert kind is DeclareAbsent
        called.append(service)
        if service.startswith('/near/'):
            raise CommandError('near reports: switch it off first', NOT_DONE)
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


@pytest.mark.parametrize('words', [['b'], ['b', 'full'], ['b', '-1']])
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
    """Subscribers connect to a publisher by that name; without an address nothing would arrive."""
    assert name_problem(host).startswith(expected)
    assert bool(name_problem(host)) == bool(expected)
