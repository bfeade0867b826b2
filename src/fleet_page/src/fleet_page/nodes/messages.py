"""The conversion of the fleet manager's messages to the page's values."""
from __future__ import annotations

import math
from typing import Any, Dict, Iterable, List, Optional

from fleet_core.supervision.looks import LOOK_OF_MACHINE
from fleet_core.supervision.waits import WaitCode
from fleet_core.work.tables import LoadState
from fleet_page.core.acts import ANSWERS, Act, ActKind
from fleet_page.core.fleet import (
    DEADLINE_STATES,
    MISSION_STATES,
    ROBOT_STATES,
    MissionRequest,
    MissionStatus,
    ShownMachine,
    ShownPlan,
    ShownPose,
    ShownQueuePlace,
    ShownResource,
    ShownRobot,
)
from fleet_page.core.site import WallMap, wall_map
from fleet_page.nodes.fleet_commands import COMMANDS, EDGES
from graph_fleet_manager.messages.missions import LOAD_OF_CODE, person_of
from graph_fleet_manager.messages.resources import KIND_OF_CODE, device_of, look_of, machine_of
from itrci_nav_msgs import msg

_OUTAGES: Dict[int, str] = {
    value: name[len('OUTAGE_'):] for name, value in vars(msg.FleetRobot).items()
    if name.startswith('OUTAGE_')}

_WAITS: Dict[int, str] = {int(code): code.name for code in WaitCode}
_COMMANDS: Dict[int, ActKind] = {number: kind for kind, number in COMMANDS.items()}
_ANSWERS: Dict[int, str] = {int(decision): word for word, decision in ANSWERS.items()}
_EDGES: Dict[int, ActKind] = {number: kind for kind, number in EDGES.items()}


def robots_of(message: msg.FleetState) -> List[ShownRobot]:
    """The robots in /fleet_state, each with the device in which it is and that is not open."""
    not_open = {claim.robot: one.name for one in message.resources for claim in one.claims
                if one.has_device and claim.state == msg.ResourceClaim.LOST}
    return [_robot_of(robot, not_open.get(robot.name, '')) for robot in message.robots]


def _robot_of(message: msg.FleetRobot, not_open: str) -> ShownRobot:
    return ShownRobot(
        message.name, message.type, _word(ROBOT_STATES, message.state),
        _OUTAGES.get(message.outage_code, 'UNKNOWN'), message.pose.edge_id,
        _finite(message.pose.percentage, 0.0) / 100.0, message.seen.to_sec(),
        message.battery if math.isfinite(message.battery) else None,
        message.request_id if message.has_mission else None, message.destination,
        message.waits_for, message.to_end if math.isfinite(message.to_end) else None,
        _WAITS.get(message.waits_for_code, 'UNKNOWN'), not_open,
        LOAD_OF_CODE.get(message.load, LoadState.UNKNOWN).name, message.load_serial)


def resources_of(message: msg.FleetState) -> List[ShownResource]:
    """The stations, doors and the like in /fleet_state."""
    return [ShownResource(
        one.name, KIND_OF_CODE[one.kind].name, tuple(one.edges), tuple(one.vertices),
        '' if device is None else device.mode.name, tuple(claim.robot for claim in one.claims),
        look_of(one).name, one.is_group,
        tuple(ShownQueuePlace(place.vertex, place.robot, place.is_there) for place in one.queue))
        for one in message.resources for device in (device_of(one),)]


def machines_of(message: msg.FleetState) -> List[ShownMachine]:
    """The machines in /fleet_state."""
    return [ShownMachine(one.name, one.state.name, LOOK_OF_MACHINE[one.state].name, one.places,
                         one.robot) for one in map(machine_of, message.machines)]


def places_of(message: msg.FleetPoses) -> Dict[str, ShownPose]:
    """The poses of all robots whose position is known, by name."""
    return {pose.robot: ShownPose(pose.x, pose.y,
                                  pose.theta if math.isfinite(pose.theta) else None)
            for pose in message.poses if math.isfinite(pose.x) and math.isfinite(pose.y)}


def plans_of(message: msg.FleetPlan) -> Dict[str, ShownPlan]:
    """The plan of each robot, by name. Released edges come first."""
    return {plan.robot: ShownPlan(tuple(drive.edge_id for drive in plan.drives),
                                  sum(drive.released for drive in plan.drives))
            for plan in message.plans}


def status_of(message: msg.MissionStatus) -> MissionStatus:
    """The status of a mission."""
    return MissionStatus(message.request_id, message.request_stamp.to_nsec(),
                         _word(MISSION_STATES, message.state), message.robot,
                         message.destinations_reached, message.reason,
                         _not_done(message), message.asks, message.header.stamp.to_sec(),
                         _word(DEADLINE_STATES, message.deadline_code),
                         ' '.join((message.template, *(f'{one.name}:={one.value}'
                                                       for one in message.arguments))),
                         message.serial, tuple(message.destinations))


def _not_done(message: msg.MissionStatus) -> str:
    kind = _COMMANDS.get(message.command)
    is_not_done = message.command_code == msg.MissionStatus.COMMAND_NOT_DONE
    return kind.value if kind is not None and is_not_done else ''


def command_of(message: msg.MissionCommand) -> Optional[Act]:
    """The act of a command for an open mission; None: there is no such command."""
    kind = _COMMANDS.get(message.command)
    return None if kind is None else Act(
        kind, mission=message.request_id, priority=message.priority,
        destinations=tuple(message.destination_vertices_id),
        answer=_ANSWERS.get(message.answer, ''), step=message.step_key)


def edges_of(message: msg.EdgeCommand) -> Optional[Act]:
    """The act of a command for edges; None: there is no such command."""
    kind = _EDGES.get(message.command)
    return None if kind is None else Act(kind, edges=tuple(message.edges))


def sender_of(message: Any, own: str) -> str:
    """The requester of a message; empty if this page sent it, or if the message names none.

    own -- node name of this page
    """
    sender = (message._connection_header or {}).get('callerid', '')
    return '' if sender == own else person_of(message.requested_by)


def request_of(message: msg.MissionRequest) -> MissionRequest:
    """The request of a mission."""
    destinations = tuple(message.destination_vertices_id) or tuple(
        stop.vertex for stop in message.stops if not stop.group)
    return MissionRequest(message.request_id, message.header.stamp.to_nsec(), destinations,
                          message.robot, message.robot_type, message.priority,
                          person_of(message.requested_by))


def walls_of(message: Any) -> WallMap:
    """The walls of a nav_msgs/OccupancyGrid, whose cells are an array; raises WrongMap."""
    info = message.info
    return wall_map(message.data, info.width, info.height, info.resolution,
                    info.origin.position.x, info.origin.position.y)


def _word(words: Iterable[str], number: int) -> str:
    return dict(enumerate(words)).get(number, 'UNKNOWN')


def _finite(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise


def radii_of(fleet: Optional[Any]) -> Dict[str, float]:
    """The radius of the robots of each type, in m."""
    return {} if fleet is None else {kind.name: kind.radius for kind in fleet.types}
