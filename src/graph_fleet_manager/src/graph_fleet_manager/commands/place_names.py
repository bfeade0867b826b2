"""The names of places on a command line: ids and labels of vertices, stations, and groups."""
from __future__ import annotations

from typing import Dict, Optional

from fleet_core.work.stations import (
    Destination,
    Station,
    UnknownPlace,
    destination_of,
    place_of,
)
from graph_fleet_manager.commands.command_line import LARGEST, CommandProblem
from graph_fleet_manager.commands.fleet_client import TopicListener
from graph_fleet_manager.messages.resources import stations_of
from itrci_nav_msgs.msg import FleetState
from itrci_nav_msgs.msg import Graph as GraphMessage
from trajectory_graph import Graph
from trajectory_graph.messages import graph_from_message


class PlaceNames:
    """The names of places. The graph and the stations are requested when a name first needs them.

    The id of a vertex needs neither, because the fleet manager checks whether the vertex exists.
    """

    def __init__(self) -> None:
        self._graph: Optional[Graph] = None
        self._stations: Optional[Dict[str, Station]] = None

    @property
    def graph(self) -> Graph:
        """The graph in force."""
        if self._graph is None:
            self._graph = graph_from_message(TopicListener('/graph', GraphMessage).last())
        return self._graph

    def destination(self, word: str) -> Destination:
        """Returns the vertex or group that a word of the command line names. Raises CommandProblem.
        """
        try:
            return _id(word) if word.isdecimal() else destination_of(
                word, self._known(), self.graph)
        except UnknownPlace as unknown:
            raise CommandProblem(f'A destination is wrong: {unknown}.') from None

    def place(self, word: str) -> int:
        """Returns the vertex that a word names. Raises UnknownPlace."""
        return _id(word) if word.isdecimal() else place_of(word, self._known(), self.graph)

    def _known(self) -> Dict[str, Station]:
        if self._stations is None:
            self._stations = stations_of(TopicListener('/fleet_state', FleetState).last().resources)
        return self._stations


def _id(word: str) -> int:
    """Returns the id of a vertex. Raises UnknownPlace if the number is too large for an id."""
    if int(word) > LARGEST:
        raise UnknownPlace(f'the graph has no vertex {word}')
    return int(word)
