"""The state of a vehicle as the master is told it."""
from __future__ import annotations

from typing import TYPE_CHECKING, Optional, Tuple

from vda5050_vehicle.core.error_list import Hold
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol import values as v

if TYPE_CHECKING:
    from vda5050_vehicle.core.vehicle import Vehicle

BASE_REQUEST = 10.0  # m before the end of the base a new one is asked for


def state_of(vehicle: Vehicle) -> v.State:
    """The state as it is now."""
    order, robot, progress = vehicle.order, vehicle.robot, vehicle.driver.progress
    last_node, last_sequence = order.last_node
    if not last_node and robot.pose is not None:
        last_node = vehicle.driver.node_at(robot.pose)
    moves = robot.moves
    if robot.velocity is None:
        moves = not (progress.halted or progress.complete)
    return v.State(
        order.order_id, order.order_update_id, last_node, last_sequence, order.node_states,
        order.edge_states, vehicle.actions.states, driving=moves, battery=robot.battery,
        operating_mode=v.OperatingMode.AUTOMATIC, errors=_errors(vehicle),
        safety=v.SafetyState(robot.e_stop, robot.field_violation),
        paused=Hold.PAUSE in vehicle.holds,
        new_base_request=_wants_base(vehicle), distance_since_last_node=round(progress.along, 3),
        position=position_of(vehicle), velocity=robot.velocity,
        maps=(v.MapInformation(vehicle.identity.map_id, vehicle.identity.map_version),))


def position_of(vehicle: Vehicle) -> Optional[v.AgvPosition]:
    """Where the robot is; None where that is not known."""
    robot = vehicle.robot
    if robot.pose is None:
        return None
    return v.AgvPosition(robot.pose.x, robot.pose.y, robot.pose.theta, vehicle.identity.map_id,
                         robot.localized, robot.localization_score)


def _errors(vehicle: Vehicle) -> Tuple[v.Error, ...]:
    errors = vehicle.errors.all(vehicle.robot)
    if vehicle.codec.is_3 and vehicle.actions.is_full:
        errors += (e.INSTANT_ACTIONS_FULL.error(
            'the oldest instant actions are forgotten', v.Reference('topic', 'instantActions')),)
    return errors


def _wants_base(vehicle: Vehicle) -> bool:
    if not vehicle.order.has_horizon or vehicle.cancelling:
        return False
    ahead = sum(leg.length for leg in vehicle.legs[:vehicle.order.base_end])
    return ahead - vehicle.driver.progress.along < BASE_REQUEST
