"""Messages about the graph: docks, parking, closed edges, and the routes that robots report."""
from __future__ import annotations

from typing import TYPE_CHECKING

import genpy

from fleet_core.fleet import Fleet
from fleet_core.site.changes import ReportedRoute
from fleet_core.site.closures import Closures, EdgeAction, EdgeOperation
from itrci_nav_msgs import msg
from trajectory_graph import Graph
from trajectory_graph.messages import fill_message

if TYPE_CHECKING:  # networkx needs much memory, and only graph_server uses it, for surveys
    from fleet_core.site.survey import Survey


def graph_message(graph: Graph, stamp: genpy.Time) -> msg.Graph:
    """Returns a graph as a message; the stamp is its version."""
    message = fill_message(msg.Graph(), graph, msg.Vertex, msg.Edge)
    message.header.stamp = stamp
    return message


def docking_points_message(graph: Graph, fleet: Fleet, stamp: genpy.Time) -> msg.DockingPoints:
    """Returns the docks of a graph, with the robot types that charge there."""
    message = msg.DockingPoints(docking_points=[
        msg.DockingPoint(vertex.id, [kind.name for kind in fleet.types
                                     if vertex.id in (kind.docks or ())])
        for vertex in graph.vertices.values() if vertex.dock])
    message.header.stamp = stamp
    return message


def parking_message(found: Survey, stamp: genpy.Time) -> msg.ParkingPlaces:
    """Returns the parking vertices and capacities of a survey; the stamp is the graph's version."""
    message = msg.ParkingPlaces(vertices=sorted(found.parking), capacities=[
        msg.ParkingCapacity(one.type, one.robots, one.docks) for one in found.capacities])
    message.header.stamp = stamp
    return message


def closed_edges_message(closures: Closures) -> msg.ClosedEdges:
    """Returns the closed edges as a message."""
    message = msg.ClosedEdges(edges=sorted(closures.edges))
    message.header.stamp = genpy.Time(0, closures.stamp)
    message.header.stamp.canon()
    return message


class WrongCommand(Exception):
    """A command cannot be carried out. The text is a sentence that says why."""


def edge_operation(message: msg.EdgeCommand, sender: str) -> EdgeOperation:
    """Returns the operation of a command; raises WrongCommand.

    sender -- name of the node that sent the command. A repeated command has the same sender,
              sequence number and stamp. Without a stamp a repetition is not recognised.
    """
    try:
        action = EdgeAction(message.command)
    except ValueError:
        raise WrongCommand(f'An edge command has the code {message.command}; there are OPEN (0) '
                           'and CLOSE (1).') from None
    if not message.edges:
        raise WrongCommand('An edge command names no edge.')
    header = message.header
    identity = f'{sender} {header.seq} {header.stamp.to_nsec()}' if header.stamp else ''
    return EdgeOperation(action, frozenset(map(abs, message.edges)), identity)


def reported_route(message: msg.ExecutionRouteStates) -> ReportedRoute:
    """Returns the rest of a robot's route.

    A route with a failed edge has ended, so nothing is left.
    """
    states = message.edge_states
    ended = any(state.state == msg.EdgeState.FAILED for state in states)
    left = () if ended else tuple(state.edge_id for state in states
                                  if state.state != msg.EdgeState.COMPLETE)
    return ReportedRoute(left, message.symbolic_pose.edge_id)
