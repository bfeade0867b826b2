"""agv_sim: simulates all robots of the fleet file with `driver: agv`, in one process.

They follow the edges of the graph exactly and implement the robot's side of the route protocol
(docs/reference/route_protocol.md).

Subscribes
    /graph (itrci_nav_msgs/Graph): replaces the graph of ~graph_file
    /<robot>/target_route (itrci_nav_msgs/TargetRoute)
    /<robot>/step_command (itrci_nav_msgs/StepCommand)
Publishes
    /<robot>/execution_route_states (itrci_nav_msgs/ExecutionRouteStates, latched): at each change,
        and at 10 Hz while a route runs, at 1 Hz without a route
    /<robot>/route_refused (itrci_nav_msgs/RouteRefused)
    /<robot>/step_states (itrci_nav_msgs/StepStates, latched): at each change, and 1 Hz
    /<robot>/battery_state (sensor_msgs/BatteryState): 1 Hz
    /<robot>/pose (geometry_msgs/PoseStamped) and TF map -> <robot>/base_link: the true pose, 20 Hz
Parameters
    ~fleet_file    string  (required)
    ~graph_file    string  (empty)  trajectory graph (YAML); empty: wait for /graph
    ~sim_speed     float   1.0      factor on the AGVs' clock, 0.1 to 20
    ~control_port  int     0        TCP port on 127.0.0.1 that accepts faults and returns the true
                                    poses; 0: none
"""
from __future__ import annotations

import re
import threading
import time
from typing import Any, Dict, List, Mapping, Optional

import rospkg
import rospy
from tf2_ros import TransformBroadcaster

from fleet_core.fleet import Robot
from fleet_simulation.agv.control_socket import AgvControlServer
from fleet_simulation.agv.simulation import Simulation
from graph_fleet_manager.nodes.agv_topics import AgvTopics
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_topic import FollowedGraph
from node_lifecycle import ConfigurationError, number, parameter, run
from route_protocol.vehicle import draw_epoch, milliseconds
from trajectory_graph import Graph, GraphError, load_graph

DRIVER = 'agv'  # the driver of the robots that this node drives
PACKAGE = 'graph_fleet_manager'  # its version is reported as the version of the AGVs' software
TICK = 0.05     # s
_NAME = re.compile(r'[A-Za-z]\w*\Z', re.ASCII)


class AgvSim:
    """The node; see the docstring of the module. One lock guards the simulation."""

    def __init__(self) -> None:
        self._robots = _read_robots()
        self._speed = number('~sim_speed', 1.0, 0.1, 20.0)
        self._lock = threading.Lock()
        self._simulation: Optional[Simulation] = None
        self._topics: Dict[str, AgvTopics] = {}
        self._frames = TransformBroadcaster()
        graph_file = parameter('~graph_file', '')
        if graph_file:
            self._begin(_read_graph(graph_file), graph_file)
        port = parameter('~control_port', 0, int)
        if port:
            self._open_control(port)
        FollowedGraph(self._on_graph).subscribe()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._run, name='simulation', daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Ends the simulation thread before the topics close."""
        self._ending.set()
        self._thread.join(1.0)

    def _begin(self, graph: Graph, source: str) -> None:
        for robot in self._robots:
            if robot.vertex not in graph.vertices:
                raise ConfigurationError(
                    f'Robot {robot.name} of the fleet file stands on vertex {robot.vertex}, which '
                    f'{source} does not have; choose another.')
        simulation = Simulation(graph, self._robots, draw_epoch, milliseconds, self._speed)
        version = rospkg.RosPack().get_manifest(PACKAGE).version
        self._topics = {name: AgvTopics(vehicle, self._lock, f'agv_sim {version}')
                        for name, vehicle in simulation.vehicles.items()}
        self._simulation = simulation

    def _on_graph(self, graph: Graph, _stamp: rospy.Time) -> None:
        with self._lock:
            if self._simulation is not None:
                self._simulation.use_graph(graph)
                return
            try:
                self._begin(graph, '/graph')
            except ConfigurationError as error:
                rospy.logerr('The graph of /graph is not used: %s', error)

    def _open_control(self, port: int) -> None:
        try:
            AgvControlServer(port, self._inject, self._where)
        except (OSError, OverflowError) as error:
            raise ConfigurationError(f'The control port {port} cannot be used ({error}); choose '
                                     'another one with ~control_port.') from None

    def _inject(self, line: str) -> None:
        with self._lock:
            if self._simulation is None:
                raise ValueError('there is no graph yet')
            self._simulation.inject(line)

    def _where(self) -> Mapping[str, Any]:
        with self._lock:
            return self._simulation.where() if self._simulation else {'time': 0.0, 'robots': {}}

    def _run(self) -> None:
        before = due = time.monotonic()
        while not self._ending.wait(max(due - time.monotonic(), 0.0)):
            now = time.monotonic()
            due = max(due + TICK, now)
            with self._lock:
                if self._simulation is not None:
                    self._simulation.advance(now - before, rospy.Time.now().to_nsec())
                    frames = [topics.publish_due(now) for topics in self._topics.values()]
                    self._frames.sendTransform([frame for frame in frames if frame is not None])
            before = now


def _read_robots() -> List[Robot]:
    robots = [robot for robot in fleet_of().robots if robot.driver == DRIVER]
    if not robots:
        raise ConfigurationError('The fleet file has no robot with `driver: agv`: there is nothing '
                                 'to simulate.')
    for robot in robots:
        if not _NAME.match(robot.name):
            raise ConfigurationError(f'Robot {robot.name!r} needs a name of letters, digits and _ '
                                     'that begins with a letter: it becomes part of topics.')
    return robots


def _read_graph(path: str) -> Graph:
    try:
        return load_graph(path)
    except GraphError as error:
        raise ConfigurationError(str(error)) from None


def main() -> None:
    """Runs the node."""
    run('agv_sim', AgvSim)
