"""The conversion of the fleet manager's messages to the page's values."""
from __future__ import annotations

import math
from typing import Any, Dict, Iterable, List, Mapping, Optional, Tuple

import numpy as np
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

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
    ShownAllocation,
    ShownMachine,
    ShownPlan,
    ShownPose,
    ShownQueuePlace,
    ShownResource,
    ShownRobot,
    ShownTemplate,
    ShownTimetable,
)
from fleet_page.core.site import WallMap, wall_map
from fleet_page.nodes.fleet_commands import COMMANDS, EDGES
from graph_fleet_manager.messages.missions import LOAD_OF_CODE, person_of
from graph_fleet_manager.messages.resources import KIND_OF_CODE, device_of, look_of, machine_of
from itrci_nav_msgs import msg
from node_lifecycle.clouds import places_in
from node_lifecycle.headings import yaw_from_quaternion

MOST_POINTS = 240    # points of a laser that are shown, at most
MOST_FENCES = 20000
FAR = 1e5            # m; a point at this distance or beyond is an error
_OUTAGES: Dict[int, str] = {
    value: name[len('OUTAGE_'):] for name, value in vars(msg.FleetRobot).items()
    if name.startswith('OUTAGE_')}

_WAITS: Dict[int, str] = {int(code): code.name for code in WaitCode}
_COMMANDS: Dict[int, ActKind] = {number: kind for kind, number in COMMANDS.items()}
_ANSWERS: Dict[int, str] = {int(decision): word for word, decision in ANSWERS.items()}
_EDGES: Dict[int, ActKind] = {number: kind for kind, number in EDGES.items()}


def robots_of(message: msg.FleetState) -> List[ShownRobot]:
    """Returns the robots in /fleet_state. `not_open` of a robot names a device: the robot is in it,
    but no report says that the device is open.
    """
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
        LOAD_OF_CODE.get(message.load, LoadState.UNKNOWN).name, message.load_serial,
        message.software, tuple(one for one in message.load_types if one))


def resources_of(message: msg.FleetState) -> List[ShownResource]:
    """Returns the stations, doors and other resources in /fleet_state."""
    return [ShownResource(
        one.name, KIND_OF_CODE[one.kind].name, tuple(one.edges), tuple(one.vertices),
        '' if device is None else device.mode.name, tuple(claim.robot for claim in one.claims),
        look_of(one).name, one.is_group,
        tuple(ShownQueuePlace(place.vertex, place.robot, place.is_there) for place in one.queue))
        for one in message.resources for device in (device_of(one),)]


def machines_of(message: msg.FleetState) -> List[ShownMachine]:
    """Returns the machines in /fleet_state."""
    return [ShownMachine(one.name, one.state.name, LOOK_OF_MACHINE[one.state].name, one.places,
                         one.robot) for one in map(machine_of, message.machines)]


def places_of(message: msg.FleetPoses) -> Dict[str, ShownPose]:
    """Returns the poses of all robots whose position is known, by name."""
    return {pose.robot: ShownPose(pose.x, pose.y,
                                  pose.theta if math.isfinite(pose.theta) else None)
            for pose in message.poses if math.isfinite(pose.x) and math.isfinite(pose.y)}


def plans_of(message: msg.FleetPlan) -> Dict[str, ShownPlan]:
    """Returns the plan of each robot, by name. Released edges come first."""
    return {plan.robot: ShownPlan(tuple(plan.drives.edges), plan.released)
            for plan in message.plans}


def allocations_of(message: msg.FleetAllocations) -> Dict[str, ShownAllocation]:
    """Returns the places that each robot may occupy, by robot."""
    return {one.robot: ShownAllocation(
        tuple(zip(one.edges, (_finite(part, 0.0) for part in one.cleared))), one.vertex,
        tuple((round(_finite(line.radius, 0.0), 2), tuple(
            (round(x, 2), round(y, 2)) for x, y in zip(line.x, line.y)
            if math.isfinite(x) and math.isfinite(y))) for line in one.outlines))
        for one in message.allocations}


def laser_of(cloud: PointCloud2) -> List[int]:
    """Returns at most MOST_POINTS points of a cloud: x and y in cm, one after the other.

    Raises ValueError for a cloud that cannot be read.
    """
    places = places_in(cloud)
    step = max(-(-len(places) // MOST_POINTS), 1)
    inside = places[::step][np.abs(places[::step]).max(axis=1, initial=0.0) < FAR]
    points: List[int] = np.round(100.0 * inside).astype(int).ravel().tolist()
    return points


def fences_of(message: MarkerArray) -> Tuple[Tuple[float, ...], ...]:
    """Returns the fences that map_visualisation draws: corners of areas, and ends of lines, in m.
    At most MOST_FENCES fences are returned.
    """
    found: List[Tuple[float, ...]] = []
    for marker in message.markers:
        if marker.action != Marker.ADD:
            continue
        if marker.type == Marker.CUBE:
            found.append(_corners(marker))
        elif marker.type == Marker.LINE_LIST:
            found += [(a.x, a.y, b.x, b.y) for a, b in zip(marker.points[::2],
                                                           marker.points[1::2])]
    return tuple(tuple(round(value, 2) for value in fence) for fence in found[:MOST_FENCES]
                 if all(map(math.isfinite, fence)))


def _corners(marker: Marker) -> Tuple[float, ...]:
    place, turn = marker.pose.position, yaw_from_quaternion(marker.pose.orientation)
    corners: List[float] = []
    for along, across in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)):
        x, y = along * marker.scale.x, across * marker.scale.y
        corners += (place.x + x * math.cos(turn) - y * math.sin(turn),
                    place.y + x * math.sin(turn) + y * math.cos(turn))
    return tuple(corners)


def status_of(message: msg.MissionStatus) -> MissionStatus:
    """Returns the status of a mission."""
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


def templates_of(message: msg.MissionTemplates) -> List[ShownTemplate]:
    """Returns the templates of missions."""
    return [ShownTemplate(one.name, tuple(one.parameters)) for one in message.templates]


def timetables_of(message: msg.Timetables) -> List[ShownTimetable]:
    """Returns the timetables."""
    return [ShownTimetable(
        one.name, one.template, tuple((pair.name, pair.value) for pair in one.arguments),
        one.every, one.begin, one.end, tuple(one.days),
        None if one.is_paused else one.next.to_sec()) for one in message.timetables]


def areas_message(areas: Mapping[str, Any]) -> msg.EdgeAreas:
    """Returns the areas as a message; the page keeps them by name."""
    return msg.EdgeAreas(areas=[msg.EdgeArea(name, list(area['edges']))
                                for name, area in areas.items()])


def command_of(message: msg.MissionCommand) -> Optional[Act]:
    """Returns the act of a command for an open mission; None: the command does not exist."""
    kind = _COMMANDS.get(message.command)
    return None if kind is None else Act(
        kind, mission=message.request_id, priority=message.priority,
        destinations=tuple(message.destination_vertices_id),
        answer=_ANSWERS.get(message.answer, ''), step=message.step_key)


def edges_of(message: msg.EdgeCommand) -> Optional[Act]:
    """Returns the act of a command for edges; None: the command does not exist."""
    kind = _EDGES.get(message.command)
    return None if kind is None else Act(kind, edges=tuple(message.edges))


def sender_of(message: Any, own: str) -> str:
    """Returns the requester of a message; empty if this page sent it, or if it names no requester.

    own -- name of this page's node
    """
    sender = (message._connection_header or {}).get('callerid', '')
    return '' if sender == own else person_of(message.requested_by)


def request_of(message: msg.MissionRequest) -> MissionRequest:
    """Returns the request of a mission."""
    destinations = tuple(message.destination_vertices_id) or tuple(
        stop.vertex for stop in message.stops if not stop.group)
    return MissionRequest(message.request_id, message.header.stamp.to_nsec(), destinations,
                          message.robot, message.robot_type, message.priority,
                          person_of(message.requested_by), message.template,
                          tuple((one.name, one.value) for one in message.arguments))


def walls_of(message: Any) -> WallMap:
    """Returns the walls of a nav_msgs/OccupancyGrid with its cells in an array; raises WrongMap."""
    info = message.info
    return wall_map(message.data, info.width, info.height, info.resolution,
                    info.origin.position.x, info.origin.position.y)


def _word(words: Iterable[str], number: int) -> str:
    return dict(enumerate(words)).get(number, 'UNKNOWN')


def _finite(value: float, otherwise: float) -> float:
    return value if math.isfinite(value) else otherwise


def radii_of(fleet: Optional[Any]) -> Dict[str, float]:
    """Returns the radius of the robots of each type, in m."""
    return {} if fleet is None else {kind.name: kind.radius for kind in fleet.types}
