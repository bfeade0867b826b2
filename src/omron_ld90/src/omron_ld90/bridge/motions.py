"""The table from the robot's activity to a motion of the bridge."""
from __future__ import annotations

from typing import Dict, Tuple

from omron_arcl import ActivityKind
from omron_ld90.bridge.events import Motion

MOTIONS: Dict[ActivityKind, Motion] = {
    ActivityKind.UNKNOWN: Motion.UNKNOWN,
    ActivityKind.STOPPED: Motion.STANDING,
    ActivityKind.STOPPING: Motion.STOPPING,
    ActivityKind.GOING_TO_GOAL: Motion.GOING,
    ActivityKind.ARRIVED_AT_GOAL: Motion.ARRIVED,
    ActivityKind.GOING_TO_POINT: Motion.GOING,
    ActivityKind.ARRIVED_AT_POINT: Motion.STANDING,
    ActivityKind.FAILED: Motion.FAILED,
    ActivityKind.INTERRUPTED: Motion.STANDING,
    ActivityKind.PATROLLING: Motion.GOING,
    ActivityKind.DOING_TASK: Motion.GOING,
    ActivityKind.DOCKING: Motion.DOCKING,
    ActivityKind.DOCKED: Motion.DOCKED,
    ActivityKind.UNDOCKING: Motion.UNDOCKING,
    ActivityKind.UNDOCKED: Motion.STANDING,
    ActivityKind.PARKING: Motion.GOING,
    ActivityKind.PARKED: Motion.STANDING,
    ActivityKind.TELEOPERATED: Motion.BY_HAND,
    ActivityKind.EMERGENCY_STOP: Motion.STANDING,
    ActivityKind.MOTORS_DISABLED: Motion.STANDING,
    ActivityKind.LOST: Motion.UNKNOWN,
}
_NAMING_A_GOAL = (ActivityKind.GOING_TO_GOAL, ActivityKind.ARRIVED_AT_GOAL, ActivityKind.FAILED)


def motion_of(kind: ActivityKind, goal: str) -> Tuple[Motion, str]:
    """The motion and its goal; the goal is empty if the name is that of a task or a route."""
    return MOTIONS[kind], goal if kind in _NAMING_A_GOAL else ''
