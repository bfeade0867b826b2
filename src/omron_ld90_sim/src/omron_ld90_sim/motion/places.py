"""Poses of robots in docks, and at the start of a simulation."""
from __future__ import annotations

import random
from typing import Iterator, List, Optional, Sequence, Tuple

import numpy as np

from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.planner import NoWay
from omron_map import MapDocument, MapObject

DRIVE_IN = 250.0            # mm from the dock's pose to the pose while charging
FRONT_CLEARANCE = 20.0      # mm, least distance in front of a docked robot
START_DISTANCE = 1000.0     # mm between the start places of two robots


def docked_pose(floor: SimFloor, dock: MapObject) -> SimPose:
    """Returns the pose of a robot that charges at `dock`: up to 250 mm ahead of the dock's pose,
    if there is room.
    """
    pose = SimPose(dock.x, dock.y, dock.theta)
    steps = np.arange(0.0, DRIVE_IN + 1.0, 10.0)
    fronts = [pose.ahead(float(step) + floor.body.half_length) for step in steps]
    clear = floor.clearance_at(np.array([[front.x, front.y] for front in fronts]))
    blocked = np.flatnonzero(clear < FRONT_CLEARANCE)
    last = int(blocked[0]) - 1 if len(blocked) else len(steps) - 1
    return pose.ahead(float(steps[max(last, 0)]))


def start_places(document: MapDocument, floor: SimFloor,
                 wanted: Sequence[Optional[Tuple[float, float, float]]], seed: int = 0
                 ) -> List[SimPose]:
    """Returns the start pose of each robot. None in `wanted` (mm, mm, degrees) means a free place.

    The free places are, in this order: docks, RobotHome, goals with a heading, other goals, and
    random places. Each is farther than START_DISTANCE from the places that are taken.
    """
    chance = random.Random(seed)
    taken = [SimPose(*place) for place in wanted if place is not None]
    free = (pose for pose in _candidates(document, floor, chance)
            if all(pose.distance_to(t.x, t.y) > START_DISTANCE for t in taken))
    places = []
    for place in wanted:
        if place is None:
            pose = next(free, None)
            if pose is None:
                raise NoWay('the map has no free place where a robot could stand')
            taken.append(pose)
        else:
            pose = SimPose(*place)
            if not floor.holds(pose.x, pose.y):
                raise NoWay(f'the start at {pose.x / 1000:g}, {pose.y / 1000:g} m is outside the '
                            f'map, which reaches from {_metres(floor.origin)} to '
                            f'{_metres(floor.end)}: choose another --start')
        places.append(pose)
    return places


def _metres(point: np.ndarray) -> str:
    return f'{point[0] / 1000:g}, {point[1] / 1000:g} m'


def _candidates(document: MapDocument, floor: SimFloor, chance: random.Random) -> Iterator[SimPose]:
    for dock in document.docks:
        yield docked_pose(floor, dock)
    for home in document.homes:
        if home.extent is None:
            yield SimPose(home.x, home.y, home.theta)
        else:
            yield SimPose(home.rectangle.centre_x, home.rectangle.centre_y, home.theta)
    for goal in sorted(document.goals, key=lambda goal: not goal.has_heading):
        yield SimPose(goal.x, goal.y, goal.theta if goal.has_heading else 0.0)
    sizes = np.bincount(floor.regions.ravel())
    sizes[0] = 0
    if sizes.any():
        cells = np.argwhere(floor.regions == sizes.argmax())
        for _ in range(10 * len(cells)):
            x, y = floor.planning_points(cells[[chance.randrange(len(cells))]])[0]
            yield SimPose(float(x), float(y), 0.0)
