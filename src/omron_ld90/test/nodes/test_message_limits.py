"""The messages of the largest site are read; the limits refuse only mistakes and attacks."""
from __future__ import annotations

import io
from typing import Any

import pytest
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import PointCloud2

from itrci_nav_msgs.msg import (
    ClosedEdges,
    DockingPoint,
    DockingPoints,
    Edge,
    EdgeState,
    EdgeTime,
    ExecutionRouteStates,
    FleetPlan,
    FleetRobot,
    FleetState,
    Graph,
    MissionRequest,
    PlanAnswer,
    PlannedDrives,
    PlanRequest,
    Precedence,
    RobotPlan,
    RobotTask,
    TargetRoute,
    Vertex,
)
from node_lifecycle.message_limits import limit_of
from omron_map.occupancy import MAX_CELLS
from route_protocol.order_rules import MAXIMUM_EDGES

ROBOTS, DRIVES, EDGES = 200, 100, 20_000
NAME, TEXT = 'a_robot_of_the_hall', 500 * 'x'
PLANNED = PlannedDrives(DRIVES * [1], DRIVES * [0.5], DRIVES * [0.5])
PLANS = ROBOTS * [RobotPlan(NAME, PLANNED, 1)]
RULES = ROBOTS * DRIVES


@pytest.mark.parametrize('message', [
    TargetRoute(edges=MAXIMUM_EDGES * [1]),
    ExecutionRouteStates(edge_states=MAXIMUM_EDGES * [EdgeState()], reason=TEXT),
    MissionRequest(destination_vertices_id=MAXIMUM_EDGES * [1], dwell=MAXIMUM_EDGES * [1.0],
                   requested_by=TEXT),
    ClosedEdges(edges=EDGES * [1]),
    DockingPoints(docking_points=ROBOTS * [DockingPoint(1, [NAME])]),
    FleetState(robots=ROBOTS * [FleetRobot(name=NAME, type=NAME, waits_for=TEXT)]),
    FleetPlan(plans=PLANS),
    PlanAnswer(plans=PLANS, precedence=Precedence(
        ROBOTS * [NAME], RULES * [1], RULES * [1], RULES * [0.5], RULES * [1], RULES * [1])),
    PlanRequest(edge_times=EDGES * [EdgeTime(NAME, 1, 1.0)], tasks=ROBOTS * [
        RobotTask(robot=NAME, robot_type=NAME, released=MAXIMUM_EDGES * [1],
                  kept=PLANNED)]),
    Graph(vertices=EDGES // 2 * [Vertex(label=NAME, frame_id='map/nn0')],
          edges=EDGES * [Edge(curve_type='spline')]),
    PointCloud2(data=bytes(20_000 * 12)),
], ids=lambda message: message._type)
def test_a_large_site_needs_at_most_two_thirds_of_a_limit(message: Any):
    content = io.BytesIO()
    message.serialize(content)
    assert content.tell() <= 0.67 * limit_of(message._type)


def test_the_largest_map_that_is_published_is_read():
    content = io.BytesIO()
    OccupancyGrid().serialize(content)
    assert MAX_CELLS + content.tell() < limit_of(OccupancyGrid._type)
