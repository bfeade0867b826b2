"""The size limit, in bytes, of each message type that nodes of this workspace receive.

A limit is several times the largest message that a large site sends (200 robots, a graph of 60,000
vertices and edges). A larger message is a mistake or an attack. It would delay the node that reads
it, because Python needs some 50 bytes and 1 us for each number of an array. `bounded_messages`
applies the limits.
"""
from __future__ import annotations

from typing import Dict

_KIB, _MIB = 2**10, 2**20

POINT = 4 * _KIB
"""One pose, time or id, with its frame and stamp."""
TEXT = 64 * _KIB
"""One text or answer, or the edges or vertices of one mission or route (at most 1,000)."""
LIST = 256 * _KIB
"""One entry for every edge, vertex or goal of a graph."""
FLEET = _MIB
"""One entry for every robot, or one picture of a scanner."""
PLAN = 4 * _MIB
"""All drives of all robots."""

MAP = 100_000_000 + POINT
"""The largest map that `map_visualisation` publishes, one byte for each cell."""

OTHER = FLEET
"""The limit of all other types: nodes receive these only if a site's configuration names them."""

LIMITS: Dict[str, int] = {
    'actionlib_msgs/GoalID': POINT,
    'actionlib_msgs/GoalStatusArray': LIST,
    'diagnostic_msgs/DiagnosticArray': FLEET,
    'geometry_msgs/PointStamped': POINT,
    'geometry_msgs/PoseStamped': POINT,
    'geometry_msgs/PoseWithCovarianceStamped': POINT,
    'itrci_nav_msgs/ClosedEdges': LIST,
    'itrci_nav_msgs/DeclareAbsentRequest': POINT,
    'itrci_nav_msgs/DeclareAbsentResponse': TEXT,
    'itrci_nav_msgs/DeviceRequest': POINT,
    'itrci_nav_msgs/DeviceState': TEXT,
    'itrci_nav_msgs/DockingPoints': LIST,
    'itrci_nav_msgs/EdgeAreas': LIST,
    'itrci_nav_msgs/EdgeCommand': LIST,
    'itrci_nav_msgs/ExecutionRouteStates': TEXT,
    'itrci_nav_msgs/ExplainMissionRequest': POINT,
    'itrci_nav_msgs/ExplainMissionResponse': FLEET,
    'itrci_nav_msgs/FleetAllocations': FLEET,
    'itrci_nav_msgs/FleetPlan': PLAN,
    'itrci_nav_msgs/FleetPoses': FLEET,
    'itrci_nav_msgs/FleetState': FLEET,
    'itrci_nav_msgs/GetMissionStatusRequest': POINT,
    'itrci_nav_msgs/GetMissionStatusResponse': TEXT,
    'itrci_nav_msgs/Graph': 4 * _MIB,  # some 60,000 vertices and edges
    'itrci_nav_msgs/MissionCommand': TEXT,
    'itrci_nav_msgs/MissionRequest': TEXT,
    'itrci_nav_msgs/MissionStatus': TEXT,
    'itrci_nav_msgs/MissionTemplates': LIST,
    'itrci_nav_msgs/ParkingPlaces': LIST,
    'itrci_nav_msgs/PauseTimetableRequest': POINT,
    'itrci_nav_msgs/PauseTimetableResponse': TEXT,
    'itrci_nav_msgs/PlanAnswer': PLAN,
    'itrci_nav_msgs/PlanRequest': PLAN,
    'itrci_nav_msgs/ChargeRobotRequest': POINT,
    'itrci_nav_msgs/ChargeRobotResponse': TEXT,
    'itrci_nav_msgs/SetLoadRequest': POINT,
    'itrci_nav_msgs/SetLoadResponse': TEXT,
    'itrci_nav_msgs/StepCommand': TEXT,
    'itrci_nav_msgs/StepStates': LIST,
    'itrci_nav_msgs/TargetRoute': TEXT,
    'itrci_nav_msgs/Timetables': LIST,
    'move_base_msgs/MoveBaseActionFeedback': POINT,
    'move_base_msgs/MoveBaseActionGoal': POINT,
    'move_base_msgs/MoveBaseActionResult': TEXT,
    'nav_msgs/GetMapRequest': POINT,
    'nav_msgs/GetMapResponse': MAP,
    'nav_msgs/LoadMapRequest': TEXT,
    'nav_msgs/LoadMapResponse': MAP,
    'nav_msgs/OccupancyGrid': MAP,
    'nav_msgs/Odometry': POINT,
    'omron_ld90_msgs/CommandRefused': TEXT,
    'omron_ld90_msgs/ExecuteCommandActionFeedback': LIST,  # a line of the robot has up to 128 KiB
    'omron_ld90_msgs/ExecuteCommandActionGoal': TEXT,
    'omron_ld90_msgs/ExecuteCommandActionResult': 4 * _MIB,  # all lines of an answer
    'omron_ld90_msgs/LinkState': TEXT,
    'omron_ld90_msgs/Motion': TEXT,
    'omron_ld90_msgs/QueueJobActionFeedback': LIST,  # the segments of a job
    'omron_ld90_msgs/QueueJobActionGoal': LIST,  # the stops of a job
    'omron_ld90_msgs/QueueJobActionResult': LIST,
    'omron_ld90_msgs/RobotStatus': TEXT,
    'roscpp/GetLoggersRequest': POINT,
    'roscpp/GetLoggersResponse': TEXT,
    'roscpp/SetLoggerLevelRequest': POINT,
    'roscpp/SetLoggerLevelResponse': POINT,
    'rosgraph_msgs/Clock': POINT,
    'sensor_msgs/BatteryState': TEXT,
    'sensor_msgs/PointCloud2': FLEET,
    'std_msgs/String': TEXT,
    'std_srvs/TriggerRequest': POINT,
    'std_srvs/TriggerResponse': TEXT,
    'tf2_msgs/TFMessage': FLEET,
    'visualization_msgs/InteractiveMarkerFeedback': TEXT,
    'visualization_msgs/MarkerArray': PLAN,
}


def limit_of(message_type: str) -> int:
    """Returns the largest number of bytes that a message of this type (`package/Name`) may have."""
    return LIMITS.get(message_type, OTHER)
