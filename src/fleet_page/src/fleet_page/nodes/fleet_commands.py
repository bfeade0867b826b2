"""Carries out all acts except stops, by the topics and services that RViz and the commands use."""
from __future__ import annotations

from typing import Any, Callable, Dict, Tuple, Type

from std_srvs.srv import Trigger

from fleet_core.work.stations import Destination, UnknownPlace
from fleet_page.core.acts import ANSWERS, Act, ActKind, ActOutcome
from fleet_page.core.roles import Person
from fleet_requests import (
    ImpossibleRequest,
    NotSent,
    Sender,
    ServiceRefused,
    ServiceSilent,
    call,
    mission_request,
)
from itrci_nav_msgs.msg import EdgeCommand, MissionCommand, MissionRequest, StepParameter
from itrci_nav_msgs.srv import DeclareAbsent, PauseTimetable

COMMANDS: Dict[ActKind, int] = {
    ActKind.CANCEL: MissionCommand.CANCEL, ActKind.PAUSE: MissionCommand.PAUSE,
    ActKind.CONTINUE: MissionCommand.RESUME, ActKind.RELEASE: MissionCommand.RELEASE,
    ActKind.MODIFY: MissionCommand.MODIFY, ActKind.ANSWER: MissionCommand.ANSWER}
EDGES: Dict[ActKind, int] = {ActKind.CLOSE: EdgeCommand.CLOSE, ActKind.OPEN: EdgeCommand.OPEN}
_SERVICES: Dict[ActKind, Tuple[str, Type[Any]]] = {
    ActKind.RESUME: ('/resume_fleet', Trigger), ActKind.OUT: ('/{}/leave_fleet', Trigger),
    ActKind.IN: ('/{}/join_fleet', Trigger), ActKind.ABSENT: ('/{}/declare_absent', DeclareAbsent)}
_PAUSES: Dict[ActKind, bool] = {ActKind.PAUSE_TIMETABLE: True, ActKind.RESUME_TIMETABLE: False}


class FleetCommands:
    """The publishers and service clients. Several threads call `do`, which waits for the result.

    is_robot -- returns whether a robot has this name. Without this check, a name from the network
                could become a part of any service name
    destination -- returns the destination with a name; raises UnknownPlace
    """

    def __init__(self, is_robot: Callable[[str], bool],
                 destination: Callable[[str], Destination]) -> None:
        self._is_robot, self._destination = is_robot, destination
        self._requests = Sender(MissionRequest)
        self._commands = Sender(MissionCommand)
        self._edges = Sender(EdgeCommand)

    def do(self, act: Act, person: Person) -> ActOutcome:
        """Carries out an act for a person. Returns the outcome."""
        by = by_page(person.name)
        try:
            if act.kind in (ActKind.SEND, ActKind.RUN):
                return self._send(act, by)
            if act.kind in COMMANDS:
                return self._command(act, by)
            if act.kind in EDGES:
                return self._edge(act, by)
            return self._call(act, by)
        except (NotSent, ServiceRefused, ImpossibleRequest) as reason:
            return ActOutcome(False, str(reason))
        except UnknownPlace as unknown:
            return ActOutcome(False, f'A destination is wrong: {unknown}.')
        except ServiceSilent as error:
            return ActOutcome(False, f'{error}.')

    def _send(self, act: Act, by: str) -> ActOutcome:
        request = mission_request(
            [self._destination(one) if isinstance(one, str) else one for one in act.destinations],
            template=act.name, arguments=[StepParameter(*pair) for pair in act.arguments],
            robot=act.robot, robot_type=act.robot_type, priority=act.priority,
            dwell=list(act.stays), requested_by=by)
        self._requests.send(request)
        return ActOutcome(True, f'Sent as mission {request.request_id}.', request.request_id)

    def _command(self, act: Act, by: str) -> ActOutcome:
        self._commands.send(MissionCommand(
            request_id=act.mission, command=COMMANDS[act.kind], priority=act.priority,
            destination_vertices_id=list(act.destinations), requested_by=by,
            answer=int(ANSWERS.get(act.answer, 0)), step_key=act.step))
        return ActOutcome(True, f'Asked for mission {act.mission}.')

    def _edge(self, act: Act, by: str) -> ActOutcome:
        edges = sorted(set(act.edges))
        self._edges.send(EdgeCommand(command=EDGES[act.kind], edges=edges, requested_by=by))
        return ActOutcome(True, f'Edges {", ".join(map(str, edges))}.')

    def _call(self, act: Act, by: str) -> ActOutcome:
        if act.robot and not self._is_robot(act.robot):
            return ActOutcome(False, f'There is no robot {act.robot}.')
        if act.kind in _PAUSES:
            return ActOutcome(True, call('/pause_timetable', PauseTimetable, act.name,
                                         _PAUSES[act.kind], by))
        name, kind = _SERVICES[act.kind]
        arguments = (by,) if kind is DeclareAbsent else ()
        return ActOutcome(True, call(name.format(act.robot), kind, *arguments, requested_by=by))


def by_page(person: str) -> str:
    """Returns the requester for the fleet manager's records, if a person acts on the page."""
    return f'{person} (page)'
