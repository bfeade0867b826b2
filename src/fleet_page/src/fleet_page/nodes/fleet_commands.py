"""Carries out all acts but stops, with the topics and services of RViz's menus and the commands."""
from __future__ import annotations

import random
from typing import Any, Callable, Dict, Tuple, Type

import rospy
from std_srvs.srv import Trigger

from fleet_page.core.acts import Act, ActKind, Outcome
from fleet_page.core.roles import Person
from itrci_nav_msgs.msg import EdgeCommand, MissionCommand, MissionRequest
from itrci_nav_msgs.srv import DeclareAbsent

WAIT = 1.0  # s to wait for a service that may not exist
COMMANDS: Dict[ActKind, int] = {
    ActKind.CANCEL: MissionCommand.CANCEL, ActKind.PAUSE: MissionCommand.PAUSE,
    ActKind.CONTINUE: MissionCommand.RESUME, ActKind.RELEASE: MissionCommand.RELEASE,
    ActKind.MODIFY: MissionCommand.MODIFY}
EDGES: Dict[ActKind, int] = {ActKind.CLOSE: EdgeCommand.CLOSE, ActKind.OPEN: EdgeCommand.OPEN}
_SERVICES: Dict[ActKind, Tuple[str, Type[Any]]] = {
    ActKind.RESUME: ('/resume_fleet', Trigger), ActKind.OUT: ('/{}/leave_fleet', Trigger),
    ActKind.IN: ('/{}/join_fleet', Trigger), ActKind.ABSENT: ('/{}/declare_absent', DeclareAbsent)}


class FleetCommands:
    """The publishers and service clients. Several threads call `do`, which waits for the result.

    is_robot -- returns whether a robot has this name; else a name from the network could become
                part of any service name
    """

    def __init__(self, is_robot: Callable[[str], bool]) -> None:
        self._is_robot = is_robot
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=100)
        self._commands = rospy.Publisher('/mission_command', MissionCommand, queue_size=100)
        self._edges = rospy.Publisher('/edge_command', EdgeCommand, queue_size=100)

    def do(self, act: Act, person: Person) -> Outcome:
        """Carries out an act for a person, and returns its outcome."""
        by = f'{person.name} (page)'
        if act.kind is ActKind.SEND:
            return self._send(act, by)
        if act.kind in COMMANDS:
            return self._command(act, by)
        if act.kind in EDGES:
            return self._edge(act, by)
        return self._call(act, by)

    def _send(self, act: Act, by: str) -> Outcome:
        if not self._requests.get_num_connections():
            return Outcome(False, 'No program takes missions: is path_supervisor running?')
        request = MissionRequest(
            request_id=random.randint(1, 2 ** 31 - 1), robot=act.robot,
            destination_vertices_id=list(act.destinations), robot_type=act.robot_type,
            priority=act.priority, dwell=list(act.stays), requested_by=by)
        request.header.stamp = rospy.Time.now()
        self._requests.publish(request)
        return Outcome(True, f'Sent as mission {request.request_id}.', request.request_id)

    def _command(self, act: Act, by: str) -> Outcome:
        if not self._commands.get_num_connections():
            return Outcome(False, 'No program takes commands: is path_supervisor running?')
        command = MissionCommand(
            request_id=act.mission, command=COMMANDS[act.kind], priority=act.priority,
            destination_vertices_id=list(act.destinations), requested_by=by)
        command.header.stamp = rospy.Time.now()
        self._commands.publish(command)
        return Outcome(True, f'Asked for mission {act.mission}.')

    def _edge(self, act: Act, by: str) -> Outcome:
        if not self._edges.get_num_connections():
            return Outcome(False, 'No program takes commands for edges: is graph_server running?')
        command = EdgeCommand(command=EDGES[act.kind], edges=sorted(set(act.edges)),
                              requested_by=by)
        command.header.stamp = rospy.Time.now()
        self._edges.publish(command)
        return Outcome(True, f'Edges {", ".join(map(str, command.edges))}.')

    def _call(self, act: Act, by: str) -> Outcome:
        if act.robot and not self._is_robot(act.robot):
            return Outcome(False, f'There is no robot {act.robot}.')
        name, kind = _SERVICES[act.kind]
        service = name.format(act.robot)
        try:
            rospy.wait_for_service(service, WAIT)
            call = rospy.ServiceProxy(service, kind)
            answer = call(by) if kind is DeclareAbsent else call()
        except (rospy.ROSException, rospy.ServiceException) as error:
            return Outcome(False, f'{service} does not answer ({error}).')
        return Outcome(bool(answer.success), str(answer.message))
