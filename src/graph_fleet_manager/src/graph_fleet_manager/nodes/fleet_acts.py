"""Carries out the menu entries of a fleet with requests, commands and services."""
from __future__ import annotations

import random
import threading
from typing import Any, Callable, Dict, FrozenSet, Type

import rospy
from std_srvs.srv import Trigger

from graph_fleet_manager.commands.command_line import CommandError
from graph_fleet_manager.commands.stop import stop
from graph_fleet_manager.nodes.rviz.menus import Act, Subject
from itrci_nav_msgs.msg import EdgeCommand, FleetRobot, MissionCommand, MissionRequest
from itrci_nav_msgs.srv import DeclareAbsent

WAIT = 1.0  # s to wait for a service that may not exist
_COMMANDS = {Act.CANCEL: MissionCommand.CANCEL, Act.PAUSE: MissionCommand.PAUSE,
             Act.RESUME: MissionCommand.RESUME, Act.RELEASE: MissionCommand.RELEASE}
_SERVICES = {Act.RESUME_ALL: ('/resume_fleet', Trigger), Act.OUT: ('/{}/leave_fleet', Trigger),
             Act.IN: ('/{}/join_fleet', Trigger),
             Act.ABSENT: ('/{}/declare_absent', DeclareAbsent)}


class FleetActs:
    """Carries out the entries of menus. `say` is called with a sentence about each result."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self.robots: Dict[str, FleetRobot] = {}
        self.closed: FrozenSet[int] = frozenset()
        self.chosen = ''
        """The robot for which the next mission is requested; empty if none is chosen."""
        self._requests = rospy.Publisher('/mission_request', MissionRequest, queue_size=10)
        self._commands = rospy.Publisher('/mission_command', MissionCommand, queue_size=10)
        self._edges = rospy.Publisher('/edge_command', EdgeCommand, queue_size=10)

    def act(self, act: Act, subject: Subject) -> None:
        """Carries out one entry of a menu. Never blocks: a thread of its own calls a service."""
        if act is Act.STOP_ALL:
            threading.Thread(target=self._stop, daemon=True).start()
        elif act in _SERVICES:
            service, kind = _SERVICES[act]
            threading.Thread(target=self._call, args=(service.format(subject.robot), kind, act),
                             daemon=True).start()
        elif act in _COMMANDS:
            self._command(act, subject.robot)
        elif act is Act.CHOOSE:
            self.chosen = '' if self.chosen == subject.robot else subject.robot
            self._say(f'{self.chosen} is chosen: send it from the menu of a vertex'
                      if self.chosen else f'{subject.robot} is not chosen any more')
        elif act is Act.SEND_ANY:
            self._send(subject.vertex, '')
        elif act is Act.SEND_CHOSEN:
            if self.chosen in self.robots:
                self._send(subject.vertex, self.chosen)
            else:
                self._say('No robot is chosen: click one first')
        else:
            self._close(act, subject.edge)

    def _send(self, vertex: int, robot: str) -> None:
        request = MissionRequest(request_id=random.randint(1, 2 ** 31 - 1),
                                 destination_vertices_id=[vertex], robot=robot,
                                 requested_by=rospy.get_name())
        request.header.stamp = rospy.Time.now()
        if not self._requests.get_num_connections():
            self._say('No node takes missions: is path_supervisor running?')
            return
        self._requests.publish(request)
        self._say(f'{robot or "A robot"} is sent to vertex {vertex}, '
                  f'as mission {request.request_id}')

    def _command(self, act: Act, name: str) -> None:
        robot = self.robots.get(name)
        if robot is None or not robot.has_mission:
            self._say(f'{name} has no mission')
            return
        command = MissionCommand(request_id=robot.request_id, command=_COMMANDS[act],
                                 requested_by=rospy.get_name())
        command.header.stamp = rospy.Time.now()
        self._commands.publish(command)
        self._say(f'{act.value}: {name}, mission {robot.request_id}')

    def _close(self, act: Act, edge: int) -> None:
        edges = self.closed if act is Act.OPEN_ALL else {edge}
        if not edges:
            self._say('No edge is closed')
            return
        if not self._edges.get_num_connections():
            self._say('No program takes commands for edges: is graph_server running?')
            return
        command = EdgeCommand(edges=sorted(edges), requested_by=rospy.get_name(), command=(
            EdgeCommand.CLOSE if act is Act.CLOSE else EdgeCommand.OPEN))
        command.header.stamp = rospy.Time.now()
        self._edges.publish(command)
        self._say(f'{"Closed" if act is Act.CLOSE else "Opened"}: '
                  + ('all edges' if act is Act.OPEN_ALL else f'edge {edge}'))

    def _stop(self) -> None:
        try:
            self._say(stop())
        except CommandError as error:
            self._say(f'{Act.STOP_ALL.value}: NOT DONE: {error}')

    def _call(self, service: str, kind: Type[Any], act: Act) -> None:
        try:
            rospy.wait_for_service(service, WAIT)
            answer = rospy.ServiceProxy(service, kind)()
        except (rospy.ROSException, rospy.ServiceException) as error:
            self._say(f'{act.value}: NOT DONE, {service} does not answer ({error})')
            return
        if answer.success:
            self._say(answer.message or f'{act.value}: done')
        else:
            self._say(f'{act.value}: NOT DONE: {answer.message}')
