"""Decides whether a click in RViz may move the robot. While a fleet drives it, no click may."""
from __future__ import annotations

import threading
import time
from typing import Callable, Optional

import rospy

from itrci_nav_msgs.msg import ExecutionRouteStates, FleetRobot, FleetState
from node_lifecycle import parameter
from omron_ld90.operator.route_watch import RouteWatch

SILENCE = 3.0  # s without /fleet_state after which the robot counts as unmanaged
WITH_A_PERSON = frozenset((FleetRobot.TAKEN_OVER, FleetRobot.FAILED, FleetRobot.OFF_GRAPH,
                           FleetRobot.OUT_OF_SERVICE))
"""States in which the fleet manager waits for a person to bring the robot back."""


class ClickRule:
    """Finds out from /fleet_state and from the reported routes whether a fleet drives the robot.

    robot          -- the robot's name in the fleet, which is the name of its namespace
    allow_takeover -- clicks are always allowed; a running route then ends as `taken over`
    """

    def __init__(self, robot: str, allow_takeover: bool = False,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self.robot = robot
        self._allow_takeover = allow_takeover
        self._clock = clock
        self._lock = threading.Lock()
        self._managed: Optional[float] = None  # when a fleet manager last reported the robot
        self._routes = RouteWatch()

    @classmethod
    def of_this_node(cls) -> ClickRule:
        """Returns the rule for the robot of the node's namespace, with `~allow_takeover`.

        Subscribes to the topics that the rule needs.
        """
        rule = cls(rospy.get_namespace().strip('/'), parameter('~allow_takeover', False, bool))
        rospy.Subscriber('/fleet_state', FleetState, rule.on_fleet, queue_size=1)
        rospy.Subscriber('execution_route_states', ExecutionRouteStates, rule.on_route,
                         queue_size=10, tcp_nodelay=True)
        return rule

    @property
    def asks_for_missions(self) -> bool:
        """Whether a fleet manager drives the robot, so that clicks become missions."""
        with self._lock:
            return (not self._allow_takeover and self._managed is not None
                    and self._clock() - self._managed <= SILENCE)

    def refusal(self) -> Optional[str]:
        """Returns why a click must not move the robot, and what to do instead; None if it may."""
        if self.asks_for_missions:
            return (f'Not sent: the fleet manager drives {self.robot}. Use "rosrun '
                    f'graph_fleet_manager mission VERTEX --robot {self.robot}", or "fleet out '
                    f'{self.robot}" first.')
        with self._lock:
            route = self._routes.running(self._clock())
        if route is not None and not self._allow_takeover:
            return f'Not sent: the fleet drives route {route}. Stop it first.'
        return None

    def on_fleet(self, message: FleetState) -> None:
        """Takes the fleet manager's report about its robots."""
        own = next((robot for robot in message.robots if robot.name == self.robot), None)
        is_managed = own is not None and own.state not in WITH_A_PERSON
        with self._lock:
            self._managed = self._clock() if is_managed else None

    def on_route(self, message: ExecutionRouteStates) -> None:
        """Takes the robot's report about its route."""
        with self._lock:
            self._routes.update(message.route_id, [edge.state for edge in message.edge_states],
                                self._clock())
