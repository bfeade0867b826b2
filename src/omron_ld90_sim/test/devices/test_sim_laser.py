"""The laser: its ranges, compared with the true geometry."""
from __future__ import annotations

import math

import numpy as np
import pytest
from sim_builders import LAB, Rig, fleet, room

from omron_ld90_sim.devices import laser
from omron_ld90_sim.motion.floor import SimFloor
from omron_ld90_sim.motion.kinematics import LD90_BODY, SimPose
from omron_map import MapDocument

ANGLES = np.radians(np.linspace(-120.0, 120.0, laser.RAYS))


def true_ranges(document: MapDocument, pose: SimPose) -> np.ndarray:
    """Returns the distances to the nearest line of a map, computed without a grid."""
    angles = ANGLES + math.radians(pose.theta)
    nearest = np.full(len(angles), np.inf)
    for x1, y1, x2, y2 in np.asarray(document.lines, float):
        ex, ey, sx, sy = x2 - x1, y2 - y1, x1 - pose.x, y1 - pose.y
        with np.errstate(divide='ignore', invalid='ignore'):
            across = np.cos(angles) * ey - np.sin(angles) * ex
            distance = (sx * ey - sy * ex) / across
            part = (sx * np.sin(angles) - sy * np.cos(angles)) / across
        hit = (distance > 0) & (part >= 0) & (part <= 1) & (distance <= laser.RANGE)
        nearest = np.where(hit, np.minimum(nearest, distance), nearest)
    return nearest


@pytest.mark.parametrize('pose', [SimPose(0.0, 2000.0, 0.0), SimPose(-3000.0, 0.0, 90.0),
                                  SimPose(4000.0, -2500.0, -150.0), SimPose(1500.0, 2700.0, 33.3)])
def test_every_ray_ends_at_the_nearest_wall(pose: SimPose) -> None:
    document = room()
    floor = SimFloor.from_map(document)
    ranges, expected = laser.scan(floor, pose), true_ranges(document, pose)
    assert np.isfinite(ranges).all()
    # A ray along a wall may end in any cell of the wall. So the hits are compared with the walls,
    # but the ranges are not compared.
    assert np.percentile(np.abs(ranges - expected), 90) < 2.0 * floor.resolution
    near = SimFloor(np.empty((0, 2)), np.asarray(document.lines, float), np.empty((0, 4)), [], 20,
                    np.empty((0, 2)))
    assert near.clearance_at(laser.points(pose, ranges)).max() < 2.0 * floor.resolution


def test_240_degrees_up_to_15_metres() -> None:
    walls = np.array([[x, -20000.0, x, 20000.0] for x in (-14900.0, 15100.0)])
    floor = SimFloor(np.empty((0, 2)), walls, np.empty((0, 4)), [], 20, np.empty((0, 2)))
    ahead = laser.scan(floor, SimPose(0.0, 0.0, 0.0))
    assert np.isinf(ahead[laser.RAYS // 2]), 'the wall ahead must be 15.1 m away'
    back = laser.scan(floor, SimPose(0.0, 0.0, 180.0))
    assert back[laser.RAYS // 2] == pytest.approx(14900.0, abs=20.0)
    hits = laser.points(SimPose(0.0, 0.0, 180.0), back)
    assert np.isfinite(back).sum() < 40 and (hits[:, 0] < -14800.0).all()
    circle = laser.points(SimPose(0.0, 0.0, 0.0), np.full(laser.RAYS, 1000.0))
    bearing = np.degrees(np.arctan2(circle[:, 1], circle[:, 0]))
    assert (bearing.min(), bearing.max()) == (pytest.approx(-120.0), pytest.approx(120.0))


def test_what_is_forbidden_is_not_seen_and_what_is_there_is() -> None:
    document = MapDocument.load(str(LAB))
    assert document.forbidden_areas or document.forbidden_lines
    plain = SimFloor(np.asarray(document.points, float), np.asarray(document.lines, float),
                     np.empty((0, 4)), [], document.resolution, np.empty((0, 2)))
    goal = document.goals[0]
    pose = SimPose(goal.x, goal.y, 0.0)
    hits = laser.points(pose, laser.scan(SimFloor.from_map(document), pose))
    assert len(hits) > 300
    assert plain.clearance_at(hits).max() < 2.0 * plain.resolution


def test_robots_and_blocks_are_seen_where_they_are() -> None:
    me, _ = fleet(room(), (-3000.0, 2000.0, 0.0), (-1000.0, 2000.0, 90.0))
    hit = me.robot.scan()[laser.RAYS // 2]
    assert hit == pytest.approx([-1000.0 - LD90_BODY.half_width, 2000.0], abs=40.0)
    lonely = Rig(start=(-3000.0, 2000.0, 0.0))
    seen = lonely.robot.scan()[laser.RAYS // 2]
    assert seen[0] == pytest.approx(6000.0, abs=60.0)
    lonely.robot.navigation.blocks.append(me.robot.navigation.obstacles()[0])
    assert lonely.robot.scan()[laser.RAYS // 2][0] == pytest.approx(-1430.0, abs=40.0)
