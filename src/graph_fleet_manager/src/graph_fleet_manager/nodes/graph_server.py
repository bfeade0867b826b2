"""graph_server: keeps the fleet's graph, publishes it, and reports which limits follow from it.

Publishes (all latched)
    /graph (itrci_nav_msgs/Graph): the graph in force; header.stamp is its version
    /docking_points (itrci_nav_msgs/DockingPoints)
    /parking (itrci_nav_msgs/ParkingPlaces): vertices where robots may stand while the present edges
        are closed, and the number of robots for which the graph has room
    /closed_edges_in_force (itrci_nav_msgs/ClosedEdges)
    /diagnostics
Subscribes
    /edge_command (itrci_nav_msgs/EdgeCommand): opens or closes edges; other edges stay as they are
    /closed_edges (itrci_nav_msgs/ClosedEdges): the complete list of closed edges
    /<robot>/execution_route_states of every robot in the fleet file: routes that a new graph must
        not break
Services
    /reload_graph (std_srvs/Trigger): reads the graph file again
Parameters
    ~graph_file           string  (required)  trajectory graph (YAML)
    ~fleet_file           string  (required)  fleet file (YAML)
    ~closed_edges_file    string  graph_fleet_manager/closed_edges.json in ROS_HOME
    ~graph_in_force_file  string  graph_fleet_manager/graph_in_force.yaml in ROS_HOME
"""
from __future__ import annotations

import os
import threading
import time
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import FrozenSet, List, Optional, Tuple

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from fleet_core.files.errors import FileError
from fleet_core.fleet import Fleet
from fleet_core.planning.road_network import RoadNetwork
from fleet_core.site.closures import Closures
from fleet_core.site.graph_in_force import GraphInForce
from fleet_core.site.remarks import Remark, remarks
from fleet_core.site.survey import Survey, parking_for_all, survey
from graph_fleet_manager.messages.graphs import (
    docking_points_message,
    graph_message,
    parking_message,
    reported_route,
)
from graph_fleet_manager.nodes.edge_closures import EdgeClosures
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from itrci_nav_msgs.msg import DockingPoints, ExecutionRouteStates, ParkingPlaces
from itrci_nav_msgs.msg import Graph as GraphMessage
from node_lifecycle import ConfigurationError, parameter, publish_diagnostics, run
from node_lifecycle.worker import start_worker
from trajectory_graph import Graph
from trajectory_graph.drawn_names import size_of

_REPORTED_WITHIN = 3.0  # s within which each connected robot reports, at 1 Hz or more
_WAITING = 'The file has changed since it was last in force: waiting for the reports of the robots.'
_SURVEY_NICENESS = 10  # a survey needs seconds of CPU time, and no program waits for it


class GraphServer:
    """The node; see the docstring of the module.

    `_lock` guards the graph in force, its version and the closures. The attributes are the graph in
    force, all that is published about it, and a publisher for each topic.
    """

    def __init__(self) -> None:
        self._fleet: Fleet = fleet_of()
        file = parameter('~graph_file')
        closures = _closures()
        self._in_force = GraphInForce(parameter('~graph_in_force_file', '')
                                      or _state_file('graph_in_force.yaml'))
        self._lock = threading.RLock()
        self._stamp = rospy.Time(0)
        self._trouble = ''
        """Why the last reading of the file did not put its graph in force; empty: it did."""
        self._remarks: List[Remark] = []
        self._surveyed: Optional[Tuple[RoadNetwork, Survey]] = None
        """The network and the survey of the graph in force, with all edges open."""
        self._parked_with: FrozenSet[int] = frozenset()
        """The closed edges for which the last /parking was computed."""
        self._graphs = rospy.Publisher('/graph', GraphMessage, queue_size=1, latch=True)
        self._docks = rospy.Publisher('/docking_points', DockingPoints, queue_size=1, latch=True)
        self._parking = rospy.Publisher('/parking', ParkingPlaces, queue_size=1, latch=True)
        self._closures = EdgeClosures(closures, self._lock, lambda: self._graph,
                                      self._begin_parking)
        publish_diagnostics('none', {'graph': self._report_graph,
                                     'closed edges': self._closures.report})
        self._closures.listen()
        self._subscribers = [
            rospy.Subscriber(f'/{robot.name}/execution_route_states', ExecutionRouteStates,
                             self._on_report, robot.name, queue_size=1)
            for robot in self._fleet.robots]
        self._is_waiting = self._in_force.must_hear_robots(file)
        if self._is_waiting:
            rospy.logwarn('%s: %s', file, _WAITING)
            start_worker('first graph', self._load_later)
        else:
            self._load_first()
        self._service = rospy.Service('/reload_graph', Trigger, self._reload)

    # -- the graph --------------------------------------------------------------------------------

    def _load_later(self) -> None:
        time.sleep(_REPORTED_WITHIN)
        self._load_first()

    def _load_first(self) -> None:
        self._is_waiting = False
        trouble = self._load()
        if trouble:
            rospy.logerr('%s Correct it and call /reload_graph.', trouble)

    def _reload(self, _: TriggerRequest) -> TriggerResponse:
        if self._is_waiting:
            return TriggerResponse(False, _WAITING)
        before = self._stamp
        trouble = self._load()
        if trouble:
            rospy.logwarn('The graph was not reloaded, the one in force stays: %s', trouble)
            return TriggerResponse(False, trouble)
        file = rospy.get_param('~graph_file')
        if self._stamp == before:
            return TriggerResponse(True, f'{file} has the graph that is already in force.')
        graph = self._graph
        assert graph is not None
        return TriggerResponse(True, f'{file} is in force: {len(graph.vertices)} vertices, '
                               f'{len(graph.edges)} edges.')

    def _load(self) -> str:
        """Reads the file and puts its graph in force. Returns a sentence on failure, else ''."""
        with self._lock:
            try:
                changed, self._trouble = self._in_force.load(parameter('~graph_file'))
            except ConfigurationError as error:
                changed, self._trouble = False, str(error)
            if changed:
                self._publish_graph()
            return self._trouble

    @property
    def _graph(self) -> Optional[Graph]:
        return self._in_force.graph

    def _publish_graph(self) -> None:
        """Publishes a new graph in force."""
        graph = self._graph
        assert graph is not None
        self._remarks, self._surveyed, self._parked_with = [], None, frozenset()
        self._stamp = max(rospy.Time.now(), self._stamp + rospy.Duration(0, 1))
        self._closures.use_graph(graph)
        self._graphs.publish(graph_message(graph, self._stamp))
        self._docks.publish(docking_points_message(graph, self._fleet, self._stamp))
        self._closures.publish()
        rospy.loginfo('The graph has %s, %.0f m in all; it is being surveyed.', size_of(graph),
                      sum(graph.curve(id).length for id in graph.edges))
        start_worker('survey', partial(self._survey, graph, self._stamp))

    def _survey(self, graph: Graph, stamp: rospy.Time) -> None:
        """Surveys a graph. Publishes the results if the graph is still in force after that."""
        with suppress(PermissionError):  # hardened services may not change a priority
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _SURVEY_NICENESS)
        network = RoadNetwork(graph, (), self._fleet.dock_approach)
        found = survey(network, self._fleet)
        said = remarks(graph, self._fleet, found)
        with self._lock:
            if stamp != self._stamp:
                return
            self._remarks = said
            self._surveyed = network, found
            self._parking.publish(parking_message(found, stamp))
        for remark in said:
            (rospy.logwarn if remark.warning else rospy.loginfo)('%s', remark.text)
        self._park_by_closures()

    def _begin_parking(self) -> None:
        start_worker('parking', self._park_by_closures)

    def _park_by_closures(self) -> None:
        """Computes and publishes the parking vertices for the edges that are closed now. Until
        then the last /parking stays valid.
        """
        with self._lock:
            known, closed = self._surveyed, self._closures.edges
        if known is None or closed == self._parked_with:
            return
        network, found = known
        parking = parking_for_all(network.with_closed(closed), self._fleet)
        with self._lock:
            if known is self._surveyed and closed == self._closures.edges:
                self._parked_with = closed
                self._parking.publish(parking_message(replace(found, parking=parking),
                                                      self._stamp))

    # -- robots -----------------------------------------------------------------------------------

    def _on_report(self, message: ExecutionRouteStates, robot: str) -> None:
        self._in_force.routes[robot] = reported_route(message)

    # -- diagnostics ------------------------------------------------------------------------------

    def _report_graph(self, status: DiagnosticStatusWrapper) -> None:
        graph, said = self._graph, self._remarks
        warnings = [remark.text for remark in said if remark.warning]
        if graph is None:
            status.summary(DiagnosticStatus.ERROR, self._trouble or _WAITING)
        elif self._trouble:
            status.summary(DiagnosticStatus.WARN, f'not reloaded: {self._trouble}')
        elif warnings:
            status.summary(DiagnosticStatus.WARN, warnings[0])
        else:
            status.summary(DiagnosticStatus.OK, f'in force: {size_of(graph)}')
        status.add('file', rospy.get_param('~graph_file', ''))
        if graph is not None and not said:
            status.add('survey', 'is running')
        for k, remark in enumerate(said, 1):
            status.add(f'remark {k}', remark.text)


def _state_file(name: str) -> str:
    return os.path.join(rospkg.get_ros_home(), 'graph_fleet_manager', name)


def _closures() -> Closures:
    try:
        return Closures(parameter('~closed_edges_file', '') or _state_file('closed_edges.json'))
    except FileError as error:
        raise ConfigurationError(str(error)) from None


def main() -> None:
    """Runs the node."""
    run('graph_server', GraphServer)
