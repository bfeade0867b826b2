"""Each obstacle to joining two computers is named, with advice."""
from __future__ import annotations

from typing import Dict, Iterator

import pytest
from joined_side import OtherSide, unused_port

from graph_fleet_manager.multimaster import network_checks
from graph_fleet_manager.multimaster.findings import (
    Checked,
    Grade,
    clock_finding,
    definitions_finding,
)
from graph_fleet_manager.multimaster.network_checks import NetworkChecks
from graph_fleet_manager.multimaster.peer_master import Discovery, MasterApi, NoAnswer

DEFINITIONS = {'itrci_nav_msgs/TargetRoute': 'a', 'itrci_nav_msgs/EdgeState': 'b'}
ROBOT, FLEET = '127.0.9.2', '127.0.9.3'


@pytest.fixture
def own() -> Iterator[OtherSide]:
    side = OtherSide(ROBOT)
    yield side
    side.close()


@pytest.fixture
def other() -> Iterator[OtherSide]:
    side = OtherSide(FLEET)
    side.definitions = dict(DEFINITIONS)
    yield side
    side.close()


@pytest.fixture(autouse=True)
def short(monkeypatch) -> None:
    monkeypatch.setattr(network_checks, '_CALL_BACK', 0.5)


def findings(own: OtherSide, other: OtherSide, host: str = FLEET, master_port: int = 0,
             **environment: str) -> Dict[str, Checked]:
    shell = {'ROS_IP': ROBOT, 'ROS_MASTER_URI': f'http://{ROBOT}:{own.master_port}',
             **environment}
    checks = NetworkChecks(host, shell, DEFINITIONS, master_port or other.master_port,
                           other.discovery_port)
    return {finding.subject: finding for finding in checks.run()}


def wrong(found: Dict[str, Checked]) -> Dict[str, str]:
    return {name: str(finding) for name, finding in found.items() if finding.level is not Grade.OK}


def test_where_all_is_well_everything_was_looked_at(own, other):
    found = findings(own, other)
    assert wrong(found) == {}
    assert list(found) == ['name', 'ROS_IP', 'own master', 'master', 'way back', 'nodes',
                           'node names', 'discovery', 'clock', 'definitions']


def test_nothing_is_left_behind_at_the_other_master(own, other):
    findings(own, other)
    assert other.registered == []


def test_a_name_without_an_address_ends_the_checks(own, other):
    found = findings(own, other, host='nobody.invalid')
    assert list(found) == ['name']
    assert '/etc/hosts' in found['name'].advice


@pytest.mark.parametrize('environment, problem, advice', [
    ({'ROS_IP': ''}, 'not set', 'export ROS_IP=127.'),
    ({'ROS_IP': '192.0.2.77'}, 'no address of this computer', 'export ROS_IP=127.'),
    ({'ROS_HOSTNAME': 'robot'}, 'overrides ROS_IP', 'unset ROS_HOSTNAME')])
def test_how_this_computer_names_itself(own, other, environment, problem, advice):
    found = findings(own, other, **environment)['ROS_IP']
    assert found.level is Grade.WRONG
    assert problem in found.text
    assert advice in found.advice


def test_an_own_master_that_does_not_answer(own, other):
    found = findings(own, other, ROS_MASTER_URI=f'http://{ROBOT}:{unused_port(ROBOT)}')
    assert 'no ROS master answers' in wrong(found)['own master']


def test_another_master_that_does_not_answer(own, other):
    port = unused_port(FLEET)
    found = findings(own, other, master_port=port)
    assert f'open TCP port {port} in its firewall' in wrong(found)['master']
    assert 'way back' not in found


def test_another_master_that_does_not_reach_this_computer(own, other):
    other.calls_back = False
    assert 'does not reach this computer at 127.0.9.2' in wrong(findings(own, other))['way back']


def test_nodes_that_give_out_an_address_where_they_are_not_reached(own, other):
    other.nodes['/rosout'] = 'http://robot.invalid:40000/'
    assert f'export ROS_IP={FLEET} there' in wrong(findings(own, other))['nodes']


def test_nodes_that_crossed_are_not_taken_for_the_other_computers(own, other):
    other.nodes['/agv_1/agv_sim'] = 'http://192.0.2.77:40000/'
    assert wrong(findings(own, other)) == {}


def test_a_node_on_both_sides_is_named_and_one_that_crossed_is_not(own, other):
    own.nodes['/path_supervisor'] = f'http://{ROBOT}:1/'
    other.nodes['/path_supervisor'] = f'http://{FLEET}:{other.master_port}/'
    own.nodes['/bridge'] = other.nodes['/bridge'] = f'http://{ROBOT}:2/'
    assert 'both sides have a node /path_supervisor' in wrong(findings(own, other))['node names']


def test_definitions_of_another_version(own, other):
    other.definitions = {'itrci_nav_msgs/TargetRoute': 'z'}
    said = wrong(findings(own, other))['definitions']
    assert 'other definitions of itrci_nav_msgs/TargetRoute' in said
    assert 'no definitions of itrci_nav_msgs/EdgeState' in said


@pytest.mark.parametrize('offset, level', [(0.0, Grade.OK), (-0.1, Grade.OK), (0.5, Grade.WARN),
                                           (-0.5, Grade.WARN), (3.0, Grade.WRONG)])
def test_clocks(own, other, offset, level):
    other.clock_offset = offset
    found = findings(own, other)['clock']
    assert found.level is level
    assert ('NTP' in found.advice) == (level is not Grade.OK)


def test_a_slow_answer_does_not_make_a_clock_wrong():
    assert clock_finding(0.9, 1.0).level is Grade.OK
    assert 'ahead of' in clock_finding(0.9, 1.0).text
    assert 'behind' in clock_finding(-2.0, 0.1).text


def test_more_definitions_on_the_other_side_do_no_harm():
    assert definitions_finding({'a': '1'}, {'a': '1', 'b': '2'}).level is Grade.OK


def test_who_is_not_there_gives_no_answer():
    port = unused_port(FLEET)
    for question in (MasterApi(f'http://{FLEET}:{port}').nodes, Discovery(FLEET, port).clock):
        with pytest.raises(NoAnswer):
            question()


@pytest.mark.parametrize('offset', [float('nan'), float('inf')])
def test_nonsense_is_no_answer(other, offset):
    other.clock_offset = offset
    with pytest.raises(NoAnswer):
        Discovery(FLEET, other.discovery_port).clock()


def test_a_server_that_is_no_master_gives_no_answer(other):
    with pytest.raises(NoAnswer):
        MasterApi(f'http://{FLEET}:{other.discovery_port}').nodes()
