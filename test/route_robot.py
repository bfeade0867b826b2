"""Common parts of the system tests of routes: the fleet manager, and a simulated robot."""
from __future__ import annotations

import io
import os
from contextlib import contextmanager
from typing import Iterator, List, Sequence, Set

import rosnode
import rospkg
import rospy
from std_msgs.msg import String

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates, TargetRoute
from omron_ld90_msgs.msg import LinkState, RobotStatus
from omron_ld90_sim import Simulator
from omron_ld90_sim.interface.recording import read_log
from system_support import CommandRecorder, Recorder, connected_publisher, wait_until
from trajectory_graph import load_graph

BRIDGE = '/omron_ld90/omron_edges_to_vertices'
MAPS = f'{rospkg.RosPack().get_path("omron_ld90")}/../../maps'
VERTEX_8 = (-12000.0, 0.0, 0.0)  # mm and degrees


class FleetManager:
    """Sends routes to the robot, and records its public messages."""

    def __init__(self) -> None:
        self.states = Recorder('/omron_ld90/execution_route_states', ExecutionRouteStates)
        self.status = Recorder('/omron_ld90/robot_status', RobotStatus)
        self.commands = CommandRecorder('omron_ld90')
        self.responses = Recorder('/omron_ld90/arcl_response', String)
        self.links = Recorder('/omron_ld90/link_state', LinkState)
        self.routes = connected_publisher('/omron_ld90/target_route', TargetRoute)
        self.wait_ready()
        self._route_id = self.states.messages[-1].route_id  # from an earlier test on the same stack

    def wait_ready(self) -> None:
        """Waits until both links are connected and the bridge reports the robot's place."""
        wait_until(self._both_links_stand, 30, 'both links to the robot')
        self.states.wait_for(lambda states: states.symbolic_pose.edge_id != 0, 30,
                             'report of the robot on the graph', after=len(self.states.messages))

    def _both_links_stand(self) -> bool:
        last = {link.link: link.state for link in self.links.messages}
        return last == {'commands': LinkState.CONNECTED, 'outgoing': LinkState.CONNECTED}

    def order(self, edges: Sequence[int]) -> int:
        """Publishes a route with a new id."""
        self._route_id += 1
        self.routes.publish(TargetRoute(route_id=self._route_id, edges=list(edges)))
        return self._route_id

    def end_of(self, route_id: int, timeout: float = 120.0) -> ExecutionRouteStates:
        """Returns the first report about this route in which no edge is under way."""
        return self.states.wait_for(
            lambda states: states.route_id == route_id and states.edge_states
            and EdgeState.PROCESSING not in state_list(states),
            timeout, f'end of route {route_id}')

    def under_way(self, edges: Sequence[int], done: int) -> int:
        """Orders a route, and waits until `done` of its edges are complete."""
        route_id = self.order(edges)
        self.states.wait_for(
            lambda states: states.route_id == route_id
            and state_list(states).count(EdgeState.COMPLETE) == done,
            60, f'{done} edges of route {route_id} complete')
        return route_id


class RouteRobot(FleetManager):
    """The fleet manager of a robot that the test itself simulates. The robot starts at vertex 8."""

    def __init__(self, speed: float, status_period: float) -> None:
        """status_period -- s between two statuses, on the robot's clock"""
        self._speed = speed
        self.graph = load_graph(f'{MAPS}/lab_graph.yaml')
        self.robot = Simulator(
            f'{MAPS}/lab.map', port=int(os.environ['LD90_ARCL_PORT']), start=VERTEX_8, speed=speed,
            outgoing=('127.0.0.1', int(os.environ['LD90_OUTGOING_PORT'])),
            lists=((status_period, 'Status'),))
        self._session = io.StringIO()
        self.robot.log_to(self._session)
        self.robot.start()
        super().__init__()

    @contextmanager
    def at_speed(self, speed: float) -> Iterator[None]:
        """Sets the speed of the robot's clock during the `with` block: 16 for phases without
        checks, 0.5 for races.
        """
        self.robot.set_speed(speed)
        try:
            yield
        finally:
            self.robot.set_speed(self._speed)

    def drives_heard(self) -> List[str]:
        """Returns the drive commands that the robot has received, in order."""
        return [transfer.text for transfer in read_log(self._session.getvalue().splitlines())
                if transfer.direction == 'C' and transfer.text.startswith(('goto', 'dock'))]

    def restart_bridge(self, **parameters: object) -> None:
        """Ends the bridge's process. Waits until roslaunch has started it again."""
        before = rosnode.get_api_uri(rospy.get_master(), BRIDGE, skip_cache=True)
        for name, value in parameters.items():
            rospy.set_param(f'{BRIDGE}/{name}', value)
        heard, old = len(self.states.messages), self._listeners()
        rosnode.kill_nodes([BRIDGE])
        wait_until(lambda: rosnode.get_api_uri(rospy.get_master(), BRIDGE, skip_cache=True)
                   not in (None, before), 30, 'the bridge is back')
        wait_until(lambda: self._listeners() - old, 30, 'the bridge subscribes')
        self.states.wait_for(lambda states: states.symbolic_pose.edge_id != 0, 30,
                             'report of the restarted bridge', after=heard)

    def _listeners(self) -> Set[int]:
        """Returns the subscribers that would receive a route."""
        return {connection for connection, *_ in self.routes.impl.get_stats_info()}


def state_list(states: ExecutionRouteStates) -> List[int]:
    """Returns the edges' states, in order."""
    return [edge.state for edge in states.edge_states]
