"""Carries out the menu entries of a fleet with requests, commands and services."""
from __future__ import annotations

import threading
from typing import Any, Callable, Dict, FrozenSet, Type

from std_srvs.srv import Trigger

from fleet_core.supervision.missions import MissionState
from fleet_requests import NotSent, Sender, ServiceRefused, ServiceSilent, call, mission_request
from graph_fleet_manager.commands.command_line import CommandProblem
from graph_fleet_manager.commands.fleet_client import requested_by
from graph_fleet_manager.commands.stop import stop
from graph_fleet_manager.nodes.rviz.menus import ANSWERS, Ask, MenuAct, Subject
from itrci_nav_msgs.msg import (
    EdgeCommand,
    FleetRobot,
    MissionCommand,
    MissionRequest,
    MissionStatus,
)
from itrci_nav_msgs.srv import DeclareAbsent

_COMMANDS = {MenuAct.CANCEL: MissionCommand.CANCEL, MenuAct.PAUSE: MissionCommand.PAUSE,
             MenuAct.RESUME: MissionCommand.RESUME, MenuAct.RELEASE: MissionCommand.RELEASE}
_ANSWERS = {MenuAct.RETRY: MissionCommand.RETRY, MenuAct.SKIP: MissionCommand.SKIP,
            MenuAct.DONE: MissionCommand.DONE, MenuAct.FAIL: MissionCommand.FAIL}
_SERVICES = {MenuAct.RESUME_ALL: ('/resume_fleet', Trigger),
             MenuAct.OUT: ('/{}/leave_fleet', Trigger), MenuAct.IN: ('/{}/join_fleet', Trigger),
             MenuAct.ABSENT: ('/{}/declare_absent', DeclareAbsent)}


class FleetActs:
    """Carries out the entries of menus. `say` gets a sentence about each result."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say, self._by = say, requested_by('RViz')
        self.robots: Dict[str, FleetRobot] = {}
        self.closed: FrozenSet[int] = frozenset()
        self.chosen = ''
        """The robot for which the next mission is requested; empty if none is chosen."""
        self._asking: Dict[int, Ask] = {}  # by the id of the mission's request
        self._requests = Sender(MissionRequest)
        self._commands = Sender(MissionCommand)
        self._edges = Sender(EdgeCommand)

    def mission_said(self, status: MissionStatus) -> None:
        """Notes whether a step of a mission waits for an answer.

        If a person or a program outside does a step, the robot cannot repeat the step, so RETRY is
        not offered.
        """
        if not status.asks or not MissionState(status.state).is_open:
            self._asking.pop(status.request_id, None)
        else:
            first = 0 if status.state == MissionState.NEEDS_PERSON else 1
            self._asking[status.request_id] = Ask(status.asks, ANSWERS[first:])

    def asks(self) -> Dict[str, Ask]:
        """Returns the step that waits for an answer in each robot's mission, by robot."""
        return {name: self._asking[robot.request_id] for name, robot in self.robots.items()
                if robot.has_mission and robot.request_id in self._asking}

    def act(self, act: MenuAct, subject: Subject) -> None:
        """Carries out one entry of a menu. Never blocks: services are called in new threads."""
        if act is MenuAct.STOP_ALL:
            threading.Thread(target=self._stop, daemon=True).start()
        elif act in _SERVICES:
            service, kind = _SERVICES[act]
            threading.Thread(target=self._call, args=(service.format(subject.robot), kind, act),
                             daemon=True).start()
        elif act is MenuAct.CHOOSE:
            self.chosen = '' if self.chosen == subject.robot else subject.robot
            self._say(f'{self.chosen} is chosen: send it from the menu of a vertex'
                      if self.chosen else f'{subject.robot} is not chosen any more')
        else:
            try:
                self._send(act, subject)
            except NotSent as reason:
                self._say(str(reason))

    def _send(self, act: MenuAct, subject: Subject) -> None:
        if act in _COMMANDS or act in _ANSWERS:
            self._command(act, subject)
        elif act is MenuAct.SEND_ANY:
            self._request(subject.vertex, '')
        elif act is MenuAct.SEND_CHOSEN:
            if self.chosen in self.robots:
                self._request(subject.vertex, self.chosen)
            else:
                self._say('No robot is chosen: click one first')
        else:
            self._close(act, subject.edge)

    def _request(self, vertex: int, robot: str) -> None:
        request = mission_request([vertex], robot=robot, requested_by=self._by)
        self._requests.send(request)
        self._say(f'{robot or "A robot"} is sent to vertex {vertex}, '
                  f'as mission {request.request_id}')

    def _command(self, act: MenuAct, subject: Subject) -> None:
        name, robot = subject.robot, self.robots.get(subject.robot)
        if robot is None or not robot.has_mission:
            self._say(f'{name} has no mission')
            return
        self._commands.send(MissionCommand(
            request_id=robot.request_id, command=_COMMANDS.get(act, MissionCommand.ANSWER),
            answer=_ANSWERS.get(act, 0), step_key=subject.step, requested_by=self._by))
        self._say(f'{act.value}: {name}, mission {robot.request_id}')

    def _close(self, act: MenuAct, edge: int) -> None:
        edges = self.closed if act is MenuAct.OPEN_ALL else {edge}
        if not edges:
            self._say('No edge is closed')
            return
        command = EdgeCommand(edges=sorted(edges), requested_by=self._by, command=(
            EdgeCommand.CLOSE if act is MenuAct.CLOSE else EdgeCommand.OPEN))
        self._edges.send(command)
        self._say(f'{"Closed" if act is MenuAct.CLOSE else "Opened"}: '
                  + ('all edges' if act is MenuAct.OPEN_ALL else f'edge {edge}'))

    def _stop(self) -> None:
        try:
            self._say(stop(self._by))
        except CommandProblem as error:
            self._say(f'{MenuAct.STOP_ALL.value}: NOT DONE: {error}')

    def _call(self, service: str, kind: Type[Any], act: MenuAct) -> None:
        try:
            self._say(call(service, kind, requested_by=self._by) or f'{act.value}: done')
        except ServiceSilent as error:
            self._say(f'{act.value}: NOT DONE, {error}')
        except ServiceRefused as reason:
            self._say(f'{act.value}: NOT DONE: {reason}')
