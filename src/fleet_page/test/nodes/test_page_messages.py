"""The page shows the fleet manager's messages, and sends requests as messages."""
from __future__ import annotations

import json
import math
from typing import Any, List, Tuple

import numpy as np
import pytest
import rospy
from genpy import Time
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid
from page_builders import graph
from sensor_msgs.msg import PointCloud2, PointField
from std_srvs.srv import Trigger, TriggerResponse
from visualization_msgs.msg import Marker, MarkerArray

from fleet_core.work.stations import Station, StationKind, destination_of
from fleet_page.core.acts import Act, ActKind
from fleet_page.core.fleet import (
    MISSION_STATES,
    ROBOT_STATES,
    ShownAllocation,
    ShownMachine,
    ShownPose,
    ShownQueuePlace,
    ShownResource,
    ShownTimetable,
)
from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.layers import ALLOCATION, ShownLayers
from fleet_page.core.roles import Person, UserRole
from fleet_page.core.site import WrongMap
from fleet_page.nodes import fleet_commands, fleet_stop, messages
from fleet_page.nodes.layer_topics import LayerTopics
from itrci_nav_msgs import msg
from itrci_nav_msgs.srv import DeclareAbsent, DeclareAbsentResponse, PauseTimetable

ANNA = Person('anna', UserRole.ADMIN)


@pytest.mark.parametrize('kind, words', [
    (msg.FleetRobot, ROBOT_STATES), (msg.MissionStatus, MISSION_STATES)])
def test_the_words_are_those_of_the_messages(kind, words):
    assert [getattr(kind, word) for word in words] == list(range(len(words)))


def test_whatever_numbers_a_robot_has_the_page_can_tell_them():
    state = msg.FleetRobot(name='a', state=200, outage_code=msg.FleetRobot.OUTAGE_TOO_NEAR,
                           battery=math.nan, pose=msg.SymbolicPose(1, math.inf))
    robot, = messages.robots_of(msg.FleetState(robots=[state]))
    assert (robot.state, robot.outage, robot.battery) == ('UNKNOWN', 'TOO_NEAR', None)
    model = FleetModel()
    model.update_robots([robot], 0.0)
    model.update_places(messages.places_of(msg.FleetPoses(poses=[
        msg.FleetPose('a', 1.0, 2.0, math.nan, Time(0)),
        msg.FleetPose('b', math.nan, 2.0, 0.0, Time(0))])))
    assert model.places == {'a': ShownPose(1.0, 2.0, None)}
    json.loads(model.live.update(0))


@pytest.mark.parametrize('state, not_open', [
    (msg.ResourceClaim.LOST, 'gate'), (msg.ResourceClaim.IN_USE, '')])
def test_a_robot_in_a_door_that_is_not_open_is_an_alarm(state, not_open):
    message = msg.FleetState(
        robots=[msg.FleetRobot(name='a'), msg.FleetRobot(name='b')],
        resources=[msg.FleetResource(name='gate', has_device=True, claims=[
            msg.ResourceClaim('a', state)])])
    robots = messages.robots_of(message)
    assert [robot.not_open for robot in robots] == [not_open, '']
    model = FleetModel()
    model.update_robots(robots, 0.0)
    alarm = model.live.get('alarm:robot:a')
    assert (alarm and alarm['cause']) == ('NOT_OPEN' if not_open else None)
    assert model.live.get('alarm:robot:b') is None


def test_stations_and_doors_are_told_with_what_they_show_and_the_robots_there():
    found = messages.resources_of(msg.FleetState(resources=[
        msg.FleetResource(name='gate', kind=msg.FleetResource.DOOR, edges=[17], has_device=True,
                          device_mode=msg.DeviceState.OPEN,
                          claims=[msg.ResourceClaim('a', msg.ResourceClaim.IN_USE)]),
        msg.FleetResource(name='press', kind=msg.FleetResource.STATION, vertices=[18])]))
    assert found == [ShownResource('gate', 'DOOR', (17,), (), 'OPEN', ('a',), 'OPEN'),
                     ShownResource('press', 'STATION', vertices=(18,))]
    model = FleetModel()
    model.show_resources(found)
    assert model.live.get('resource:gate')['device'] == 'OPEN'
    model.show_resources(found[1:])
    assert model.live.get('resource:gate') is None
    json.loads(model.live.update(0))


def test_the_software_of_a_robot_is_told_if_the_robot_tells_it():
    robots = messages.robots_of(msg.FleetState(robots=[
        msg.FleetRobot(name='a', software='own 2.1'), msg.FleetRobot(name='b')]))
    model = FleetModel()
    model.update_robots(robots, 0.0)
    assert [model.live.get(f'robot:{name}')['software'] for name in 'ab'] == ['own 2.1', '']


def test_queues_loads_and_machines_are_told_with_their_robots():
    message = msg.FleetState(
        robots=[msg.FleetRobot(name='a', load=msg.FleetRobot.LOAD_LOADED, load_serial=42,
                               load_types=['pallet']),
                msg.FleetRobot(name='b', load=200, load_types=[''])],
        resources=[msg.FleetResource(
            name='shelves', kind=msg.FleetResource.STATION, is_group=True,
            queue=[msg.QueuePlace(22, 'a', True), msg.QueuePlace(vertex=8)])],
        machines=[msg.FleetMachine(name='press_1', state=msg.FleetMachine.WORKING, vertices=[18],
                                   robot='a'), msg.FleetMachine(name='oven', state=77)])
    assert [(robot.load, robot.load_serial, robot.load_types)
            for robot in messages.robots_of(message)] == [
        ('LOADED', 42, ('pallet',)), ('UNKNOWN', 0, ())]
    shelves, = messages.resources_of(message)
    assert shelves.is_group
    assert shelves.queue == (ShownQueuePlace(22, 'a', True), ShownQueuePlace(8))
    machines = messages.machines_of(message)
    assert machines == [ShownMachine('press_1', 'WORKING', 'OPEN', (18,), 'a'),
                        ShownMachine('oven', 'SILENT', 'TROUBLE')]
    model = FleetModel()
    model.show_resources([shelves], machines)
    assert model.live.get('machine:press_1')['robot'] == 'a'
    json.loads(model.live.update(0))


def test_a_plan_says_how_much_of_it_is_released():
    drives = msg.PlannedDrives([1, -2], [1.0, 2.0], [2.0, 3.0])
    plan = messages.plans_of(msg.FleetPlan(plans=[msg.RobotPlan('a', drives, 1)]))['a']
    assert plan.edges == (1, -2) and plan.released == 1


def test_an_allocation_has_its_edges_its_vertex_and_its_other_places():
    found = messages.allocations_of(msg.FleetAllocations(allocations=[
        msg.RobotAllocation('a', [3, -4], [0.25, math.nan], 0, []),
        msg.RobotAllocation('b', [], [], 7, [msg.Outline([1.0, math.inf], [2.0, 0.0], 0.123)])]))
    assert found == {'a': ShownAllocation(((3, 0.25), (-4, 0.0)), 0),
                     'b': ShownAllocation((), 7, ((0.12, ((1.0, 2.0),)),))}
    model = FleetModel()
    model.show_allocations(found)
    assert model.live.get('allocation:a') == [[[3, 0.25], [-4, 0.0]], 0, []]
    json.loads(model.live.update(0, ShownLayers(frozenset((ALLOCATION,)))))


def laser(places: Any) -> PointCloud2:
    """Returns a cloud in the layout in which the robot's nodes publish a laser scan."""
    data = np.array(places, '<f4').reshape(-1, 3)
    fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate('xyz')]
    return PointCloud2(height=1, width=len(data), fields=fields, point_step=12,
                       row_step=12 * len(data), data=data.tobytes())


def test_a_laser_is_reduced_to_a_bounded_number_of_whole_centimetres():
    assert messages.laser_of(laser([[1.234, -0.5, 0.2], [math.nan, 1.0, 0.0],
                                    [1e9, 0.0, 0.0]])) == [123, -50]
    many = messages.laser_of(laser([[k, 0.0, 0.0] for k in range(1000)]))
    assert len(many) <= 2 * messages.MOST_POINTS and many[:4] == [0, 0, 500, 0]
    assert messages.laser_of(laser([])) == []
    with pytest.raises(ValueError, match='no x and y'):
        messages.laser_of(PointCloud2())


def test_fences_are_the_areas_and_lines_that_rviz_shows():
    area = Marker(type=Marker.CUBE, action=Marker.ADD)
    area.pose.position.x, area.pose.orientation.w, area.scale.x, area.scale.y = 5.0, 1.0, 2.0, 1.0
    lines = Marker(type=Marker.LINE_LIST, points=[Point(0, 1, 0), Point(2, 3, 0)])
    gone = Marker(type=Marker.CUBE, action=Marker.DELETEALL)
    assert messages.fences_of(MarkerArray([gone, area, lines])) == (
        (4.0, -0.5, 6.0, -0.5, 6.0, 0.5, 4.0, 0.5), (0.0, 1.0, 2.0, 3.0))


class Received:
    """A subscriber that keeps its handler."""

    open: List[Received] = []

    def __init__(self, topic: str, kind: Any, handler: Any, queue_size: int) -> None:
        self.topic, self.handler = topic, handler
        self.open.append(self)

    def unregister(self) -> None:
        self.open.remove(self)


def test_allocations_and_a_laser_are_received_only_while_they_are_shown(monkeypatch):
    monkeypatch.setattr(rospy, 'Subscriber', Received)
    model = FleetModel()
    layers = LayerTopics(model, lambda handler, *values: handler(*values))

    def watch(*sources: str) -> None:
        layers.watch(frozenset(sources))
        layers._thread.submit(lambda: None).result(5.0)
    watch('allocation', 'laser:a')
    assert {one.topic for one in Received.open} == {'/fleet_allocations', '/a/laser_cloud'}
    by_topic = {one.topic: one.handler for one in Received.open}
    by_topic['/a/laser_cloud'](laser([[1.0, 2.0, 0.0]]))
    by_topic['/fleet_allocations'](msg.FleetAllocations(
        allocations=[msg.RobotAllocation('a', [], [], 7, [])]))
    assert model.live.get('laser:a') == [100, 200] and model.live.get('allocation:a')
    watch()
    assert Received.open == []
    by_topic['/a/laser_cloud'](laser([[1.0, 2.0, 0.0]]))
    assert model.live.get('laser:a') is None and model.live.get('allocation:a') is None


def test_a_grid_becomes_walls():
    grid = OccupancyGrid(data=[0, 100, -1, 0])
    grid.info.width = grid.info.height = 2
    grid.info.resolution = 0.5
    assert messages.walls_of(grid).width == 1.0


def test_a_grid_that_is_too_large_is_refused_before_its_cells_are_read():
    class Cells:
        def __len__(self) -> int:
            return 10 ** 8

        def __iter__(self) -> Any:
            raise AssertionError('a cell was read')
    grid = OccupancyGrid(data=Cells())
    grid.info.width = grid.info.height = 10 ** 4
    grid.info.resolution = 0.05
    with pytest.raises(WrongMap, match='at most 4000000 cells'):
        messages.walls_of(grid)


class Topic:
    """A publisher that is connected to the nodes in `listeners` and records what it sends."""

    listeners: Tuple[str, ...] = ('/fleet_page', '/path_supervisor', '/graph_server')

    def __init__(self, *_: Any, **__: Any) -> None:
        self.sent: List[Any] = []

    def publish(self, message: Any) -> None:
        self.sent.append(message)

    @property
    def impl(self) -> Topic:
        return self

    def get_stats_info(self) -> List[Tuple[int, str]]:
        return list(enumerate(self.listeners))


@pytest.fixture
def commands(monkeypatch):
    monkeypatch.setattr(rospy, 'Publisher', Topic)
    monkeypatch.setattr(rospy.Time, 'now', lambda: Time(5))
    stations = {'press': Station('press', (18,)),
                'shelves': Station('shelves', (39, 52), kind=StationKind.GROUP)}
    return fleet_commands.FleetCommands(
        lambda name: name == 'a', lambda word: destination_of(word, stations, graph()))


def test_a_mission_is_sent_with_the_name_of_the_person(commands):
    act = Act(ActKind.SEND, destinations=(2, 3), stays=(0.0, -1.0), priority=4, robot='a')
    outcome = commands.do(act, ANNA)
    sent = commands._requests._publisher.sent[0]
    assert outcome.ok and outcome.mission == sent.request_id > 0
    assert list(sent.destination_vertices_id) == [2, 3] and list(sent.dwell) == [0.0, -1.0]
    assert (sent.priority, sent.robot) == (4, 'a') and 'anna' in sent.requested_by


def test_stations_and_groups_are_destinations(commands):
    assert commands.do(Act(ActKind.SEND, destinations=('press', 2)), ANNA).ok
    assert commands.do(Act(ActKind.SEND, destinations=('press', 'shelves')), ANNA).ok
    vertices, group = commands._requests._publisher.sent
    assert list(vertices.destination_vertices_id) == [18, 2]
    assert [(stop.vertex, stop.group) for stop in group.stops] == [(18, ''), (0, 'shelves')]


@pytest.mark.parametrize('act, told', [
    (Act(ActKind.SEND, destinations=('pres',)), "no station and no vertex is named 'pres'"),
    (Act(ActKind.SEND, destinations=('shelves',), stays=(3.0,)), 'A group takes no stay')])
def test_a_name_that_cannot_be_a_destination_is_not_sent(commands, act, told):
    outcome = commands.do(act, ANNA)
    assert not outcome.ok and told in outcome.text
    assert commands._requests._publisher.sent == []


@pytest.mark.parametrize('kind, command', [
    (ActKind.CANCEL, msg.MissionCommand.CANCEL), (ActKind.PAUSE, msg.MissionCommand.PAUSE),
    (ActKind.CONTINUE, msg.MissionCommand.RESUME), (ActKind.RELEASE, msg.MissionCommand.RELEASE),
    (ActKind.MODIFY, msg.MissionCommand.MODIFY)])
def test_a_mission_is_changed_by_its_command(commands, kind, command):
    assert commands.do(Act(kind, mission=7, priority=2, destinations=(3,)), ANNA).ok
    sent = commands._commands._publisher.sent[0]
    assert (sent.request_id, sent.command, sent.priority) == (7, command, 2)


@pytest.mark.parametrize('word, answer', [
    ('retry', msg.MissionCommand.RETRY), ('skip', msg.MissionCommand.SKIP),
    ('fail', msg.MissionCommand.FAIL), ('done', msg.MissionCommand.DONE)])
def test_a_step_is_answered_as_by_the_command_mission_answer(commands, word, answer):
    act = Act(ActKind.ANSWER, mission=7, answer=word, step=2 ** 63 + 1)
    assert commands.do(act, ANNA).ok
    sent = commands._commands._publisher.sent[0]
    assert (sent.command, sent.answer, sent.step_key) == (
        msg.MissionCommand.ANSWER, answer, 2 ** 63 + 1)
    assert messages.command_of(sent) == act


def test_a_template_is_requested_with_its_arguments(commands):
    outcome = commands.do(Act(ActKind.RUN, name='pallet', arguments=(('to', '39'),), robot='a',
                              priority=2), ANNA)
    sent = commands._requests._publisher.sent[0]
    assert outcome.ok and outcome.mission == sent.request_id
    assert (sent.template, sent.robot, sent.priority) == ('pallet', 'a', 2)
    assert [(one.name, one.value) for one in sent.arguments] == [('to', '39')]
    assert messages.request_of(sent).arguments == (('to', '39'),)


@pytest.mark.parametrize('kind, paused', [
    (ActKind.PAUSE_TIMETABLE, True), (ActKind.RESUME_TIMETABLE, False)])
def test_a_timetable_is_paused_by_its_service(commands, monkeypatch, kind, paused):
    called = []
    monkeypatch.setattr(fleet_commands, 'call', lambda *request, **_: called.append(request))
    commands.do(Act(kind, name='milk'), ANNA)
    assert called == [('/pause_timetable', PauseTimetable, 'milk', paused, 'anna (page)')]


def test_templates_timetables_and_areas_are_told_as_they_are():
    (template,) = messages.templates_of(msg.MissionTemplates(
        templates=[msg.MissionTemplate('pallet', ['from', 'to'])]))
    assert (template.name, template.parameters) == ('pallet', ('from', 'to'))
    milk = msg.Timetable(name='milk', template='pallet', every=30, begin=360, end=1080,
                         days=[0, 1], next=Time(5), arguments=[msg.StepParameter('to', '39')])
    night = msg.Timetable(name='night', is_paused=True)
    found = messages.timetables_of(msg.Timetables(timetables=[milk, night]))
    assert found[0] == ShownTimetable('milk', 'pallet', (('to', '39'),), 30, 360, 1080, (0, 1), 5.0)
    assert found[1].next is None
    (area,) = messages.areas_message({'bay': {'edges': [2, 3]}}).areas
    assert (area.name, list(area.edges)) == ('bay', [2, 3])


@pytest.mark.parametrize('kind, command', [
    (ActKind.CLOSE, msg.EdgeCommand.CLOSE), (ActKind.OPEN, msg.EdgeCommand.OPEN)])
def test_edges_are_closed_and_opened_by_a_command(commands, kind, command):
    assert commands.do(Act(kind, edges=(3, 2, 3)), ANNA).ok
    sent = commands._edges._publisher.sent[0]
    assert (list(sent.edges), sent.command) == ([2, 3], command)


@pytest.mark.parametrize('act', [
    Act(ActKind.SEND, destinations=(2,)), Act(ActKind.CANCEL, mission=1),
    Act(ActKind.CLOSE, edges=(1,))])
def test_what_no_program_takes_is_told_as_not_done(commands, monkeypatch, act):
    monkeypatch.setattr(Topic, 'listeners', ('/fleet_page',))  # it only listens for the audit
    assert not commands.do(act, ANNA).ok


@pytest.mark.parametrize('kind, service, type_, answer', [
    (ActKind.RESUME, '/resume_fleet', Trigger, TriggerResponse),
    (ActKind.OUT, '/a/leave_fleet', Trigger, TriggerResponse),
    (ActKind.IN, '/a/join_fleet', Trigger, TriggerResponse),
    (ActKind.ABSENT, '/a/declare_absent', DeclareAbsent, DeclareAbsentResponse)])
def test_robots_and_fleet_are_asked_by_their_services(commands, monkeypatch, kind, service, type_,
                                                      answer):
    called = []
    monkeypatch.setattr(rospy, 'wait_for_service', lambda *_: None)
    monkeypatch.setattr(rospy, 'ServiceProxy', lambda name, of, headers: called.append(
        (name, of, headers['requested_by'])) or (
        lambda *_: answer(False, 'it stands in the way')))
    robot = '' if kind is ActKind.RESUME else 'a'
    outcome = commands.do(Act(kind, robot=robot), ANNA)
    assert called == [(service, type_, 'anna (page)')]
    assert not outcome.ok and outcome.text == 'it stands in the way'


@pytest.mark.parametrize('name', ['nobody', '../stop_fleet', '/', 'a/b'])
def test_a_name_that_is_no_robot_calls_no_service(commands, monkeypatch, name):
    monkeypatch.setattr(rospy, 'wait_for_service', None)
    assert not commands.do(Act(ActKind.OUT, robot=name), ANNA).ok


def test_a_stop_that_did_not_work_is_told_with_its_reason(monkeypatch):
    def stop(requested_by: str) -> str:
        raise fleet_stop.CommandProblem('NO ROBOT WAS TOLD TO STOP')
    monkeypatch.setattr(fleet_stop, 'stop', stop)
    outcome = fleet_stop.stop_fleet('anna')
    assert not outcome.ok and 'NO ROBOT' in outcome.text


def test_a_direct_stop_does_not_take_the_name_of_the_page(monkeypatch):
    """A ROS master ends a node as soon as another node registers with the same name."""
    arguments = ['page', '__name:=fleet_page', '_port:=8080', '__master:=http://a:1', 'b:=c']
    monkeypatch.setattr('sys.argv', arguments)
    rospy.names.reload_mappings(arguments)
    try:
        fleet_stop.forget_node_arguments()
        assert rospy.names.get_mappings() == {'__master': 'http://a:1'}
    finally:
        rospy.names.reload_mappings([])


def asked_by(name: str, message: Any) -> Any:
    """Returns a message as it arrives from a node with this name."""
    message._connection_header = {'callerid': name}
    return message


def test_what_others_ask_for_is_told_with_their_names_and_the_own_acts_are_not_told_twice():
    command = msg.MissionCommand(request_id=7, command=msg.MissionCommand.PAUSE,
                                 requested_by='boris')
    assert messages.sender_of(asked_by('/mission', command), '/fleet_page') == 'boris'
    assert messages.sender_of(asked_by('/fleet_page', command), '/fleet_page') == ''
    assert messages.command_of(command) == Act(ActKind.PAUSE, mission=7)
    closing = msg.EdgeCommand(command=msg.EdgeCommand.CLOSE, edges=[3])
    assert messages.edges_of(closing) == Act(ActKind.CLOSE, edges=(3,))
    for unknown in (msg.MissionCommand(command=200), msg.EdgeCommand(command=200)):
        unknown_act = messages.command_of if hasattr(unknown, 'request_id') else messages.edges_of
        assert unknown_act(unknown) is None


def test_an_act_that_the_fleet_manager_did_not_carry_out_is_told():
    told = msg.MissionStatus(request_id=7, command=msg.MissionCommand.MODIFY,
                             command_code=msg.MissionStatus.COMMAND_NOT_DONE)
    assert messages.status_of(told).not_done == 'modify'
    assert messages.status_of(msg.MissionStatus(asks=2 ** 64 - 1)).asks == 2 ** 64 - 1
    told.command_code = msg.MissionStatus.COMMAND_NOT_STORED
    assert messages.status_of(told).not_done == ''
