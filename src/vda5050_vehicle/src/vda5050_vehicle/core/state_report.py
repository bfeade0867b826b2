"""Creates the state message of a vehicle for the master."""
from __future__ import annotations

from typing import Optional, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol import values as v
from vda5050_vehicle.core.context import Context

BASE_REQUEST = 10.0  # m; the vehicle requests a new base at this distance from the base's end


def state_of(context: Context) -> v.StateMessage:
    """Returns the present state."""
    state, robot = context.state, context.robot
    order = state.order
    last_node, last_sequence = order.last_node
    if not last_node and robot.pose is not None:
        last_node = context.driver.node_at(robot.pose)
    return v.StateMessage(
        order.order_id, order.order_update_id, last_node, last_sequence, order.nodes[1:],
        order.edges, state.actions.states,
        driving=robot.moves if robot.velocity is not None else not state.drive.at_rest,
        battery=robot.battery, operating_mode=v.OperatingMode.AUTOMATIC, errors=_errors(context),
        safety=v.SafetyState(robot.e_stop, robot.field_violation), paused=state.paused,
        new_base_request=_wants_base(context),
        distance_since_last_node=round(state.drive.along, 3),
        position=position_of(context), velocity=robot.velocity,
        maps=(v.MapInformation(context.identity.map_id, context.identity.map_version),))


def position_of(context: Context) -> Optional[v.AgvPosition]:
    """Returns the position of the robot; None if it is unknown."""
    robot = context.robot
    if robot.pose is None:
        return None
    return v.AgvPosition(robot.pose.x, robot.pose.y, robot.pose.theta, context.identity.map_id,
                         robot.localized, robot.localization_score)


def _errors(context: Context) -> Tuple[v.Error, ...]:
    errors = context.state.errors.all(context.robot)
    if context.codec.is_3 and context.state.actions.is_full:
        errors += (e.INSTANT_ACTIONS_FULL.error(
            'the oldest instant actions are dropped', v.ErrorReference('topic', 'instantActions')),)
    return errors


def _wants_base(context: Context) -> bool:
    state = context.state
    if not state.order.has_horizon or state.cancelling:
        return False
    ahead = sum(leg.length for leg in state.legs[:state.order.base_end])
    return ahead - state.drive.along < BASE_REQUEST
