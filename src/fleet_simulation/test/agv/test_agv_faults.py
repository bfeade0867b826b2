"""Faults of AGVs on demand."""
from __future__ import annotations

import json
import socket

import pytest
from agv_builders import GRAPH, Conversation, numbers_of_epochs
from fleet_builders import AGV

from fleet_core.fleet import Robot
from fleet_simulation.agv.control_socket import LONGEST_LINE, AgvControlServer
from fleet_simulation.agv.faults import FAULTS, UnknownAgvFault, help_text, inject
from fleet_simulation.agv.simulation import Simulation
from route_protocol.values import VehicleLocation


def on_its_way() -> Conversation:
    agv = Conversation()
    agv.order(7, 1, 2)
    agv.drive_to(1.5)
    return agv


def test_a_stall_ends_by_itself() -> None:
    agv = on_its_way()
    inject(agv.vehicle, 'stall 10')
    agv.wait(9.0)
    stood = agv.vehicle.pose
    assert agv.vehicle.drive.at_rest
    agv.wait(0.8)
    assert agv.vehicle.pose == stood
    agv.wait(20.0)
    assert agv.states() == [2, 2]


def test_a_slow_vehicle_arrives_later() -> None:
    slow, usual = on_its_way(), on_its_way()
    inject(slow.vehicle, 'slow 0.5')
    for agv in (slow, usual):
        agv.wait(8.5)
    assert (slow.states(), usual.states()) == ([2, 1], [2, 2])


def test_a_silent_vehicle_drives_on_but_neither_hears_nor_reports() -> None:
    agv = on_its_way()
    inject(agv.vehicle, 'silence 30')
    heard = len(agv.reports)
    agv.order(8)
    agv.wait(20.0)
    assert (len(agv.reports), agv.states()) == (heard, [2, 2])
    agv.wait(11.0)
    agv.order(8, 3)
    assert agv.reports[-1].route_id == 8


def test_a_vehicle_that_left_comes_back_without_its_route() -> None:
    agv = on_its_way()
    inject(agv.vehicle, 'leave')
    agv.wait(20.0)
    assert agv.vehicle.silent
    assert agv.vehicle.drive.at_rest
    inject(agv.vehicle, 'join')
    assert (agv.vehicle.silent, agv.last.route_id) == (False, 0)
    assert agv.last.pose.edge == 1
    agv.order(9, 1)
    agv.wait(20.0)
    assert agv.states() == [2]


def test_off_the_graph_no_route_is_taken_up_until_it_is_put_back() -> None:
    agv = on_its_way()
    inject(agv.vehicle, 'offgraph 1.5')
    assert agv.vehicle.pose[1] == pytest.approx(1.5)
    assert agv.last.location == VehicleLocation(*agv.vehicle.pose), (
        'only a position in metres says where it is now')
    assert (agv.last.pose.edge, agv.last.reason.text) == (0, 'off the corridor')
    agv.order(8, 1)
    assert agv.reason == 'the vehicle is off the graph'
    inject(agv.vehicle, 'place 3')
    agv.order(9, 3)
    agv.wait(20.0)
    assert agv.states() == [2]


@pytest.mark.parametrize('line, reason', [
    ('takeover', 'taken over'), ('estop', 'emergency stop'), ('fail', 'fault on demand')])
def test_what_ends_a_route(line: str, reason: str) -> None:
    agv = on_its_way()
    inject(agv.vehicle, line)
    assert (agv.states(), agv.last.reason.text) == ([3, 3], reason)


def test_an_empty_battery_ends_the_route() -> None:
    agv = on_its_way()
    inject(agv.vehicle, 'battery 0')
    agv.wait(0.1)
    assert agv.last.reason.text == 'the battery is empty'


def test_a_battery_is_charged_at_a_charger_only() -> None:
    at_charger, elsewhere = Conversation(1, chargers=[1]), Conversation(1)
    for agv in (at_charger, elsewhere):
        inject(agv.vehicle, 'battery 50')
        agv.wait(60.0)
    assert at_charger.vehicle.battery.charge == pytest.approx(51.0)
    assert elsewhere.vehicle.battery.charge < 50.0


@pytest.mark.parametrize('line, problem', [
    ('', 'there is no fault'), ('explode', "there is no fault 'explode'"),
    ('stall 1 2', 'stall takes 1 numbers, not 2'), ('stall x', 'SECONDS must be a number'),
    ('stall nan', 'SECONDS must be a number'), ('battery', 'PERCENT must be a number'),
    ('battery 101', 'PERCENT must be a number from 0 to 100'), ('place 99', 'no vertex 99')])
def test_a_wrong_fault_is_told(line: str, problem: str) -> None:
    with pytest.raises(UnknownAgvFault, match=problem):
        inject(Conversation().vehicle, line)


def test_the_help_names_every_fault() -> None:
    assert [line.split()[0] for line in help_text().splitlines()] == list(FAULTS)


# --- the control socket ---------------------------------------------------------------------------

@pytest.fixture
def ask():
    simulation = Simulation(GRAPH, [Robot('agv_1', AGV, 1), Robot('agv_2', AGV, 3)],
                            numbers_of_epochs(), lambda: 0, speed=2.0)
    simulation.advance(0.5, 1)
    server = AgvControlServer(0, simulation.inject, simulation.where)
    connection = socket.create_connection(('127.0.0.1', server.port), timeout=20.0)
    stream = connection.makefile('rwb', 0)

    def answer(line: bytes) -> str:
        stream.write(line + b'\n')
        return stream.readline().decode().strip()
    yield answer
    connection.close()
    server.shutdown()
    server.server_close()


def test_where_tells_time_and_true_poses(ask) -> None:
    assert json.loads(ask(b'where')) == {'time': 1.0, 'robots': {
        'agv_1': {'x': 0.0, 'y': 0.0, 'heading': 0.0},
        'agv_2': {'x': 8.0, 'y': 0.0, 'heading': 0.0}}}


def test_a_fault_is_for_the_vehicle_that_is_named(ask) -> None:
    assert ask(b'@agv_2 place 4') == 'ok'
    where = json.loads(ask(b'where'))['robots']
    assert (where['agv_1']['x'], where['agv_2']['x']) == (0.0, 12.0)


@pytest.mark.parametrize('line, problem', [
    (b'@nobody stall', "error: there is no AGV 'nobody'; there are: agv_1, agv_2"),
    (b'\xff\xfe', 'error: there is no fault')])
def test_what_is_wrong_is_answered_with_a_sentence(ask, line: bytes, problem: str) -> None:
    assert ask(line).startswith(problem)


def test_a_line_without_end_ends_the_connection(ask) -> None:
    assert ask(b'x' * (LONGEST_LINE + 10)) == ''
