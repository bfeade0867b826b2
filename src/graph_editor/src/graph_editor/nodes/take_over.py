"""Puts an edited graph in force, so that robots drive on it.

- If a fleet manager runs, only the fleet manager publishes /graph. Its `graph_server` reads the
  file again. If a robot drives on a changed element, it refuses the graph and names the robot.
- Otherwise the editor publishes /graph. A robot refuses the graph while it drives on a changed
  element.
"""
from __future__ import annotations

import os
from typing import List, Optional

import rosgraph
import rospy
from std_srvs.srv import Trigger

from graph_editor.nodes.graph_topic import GraphTopic
from trajectory_graph.editing import Draft

RELOAD = '/reload_graph'


class TakeOver:
    """Puts drafts in force. This node does not advertise /graph before the first draft."""

    def __init__(self) -> None:
        self._graphs: Optional[GraphTopic] = None

    def put_in_force(self, draft: Draft, file: str) -> str:
        """Puts the draft, which was saved to `file`, in force; returns the result as a sentence."""
        try:
            servers = _providers()
            if servers:
                return _reloaded(servers[0], file)
        except (rosgraph.MasterException, OSError, rospy.ServiceException) as error:
            return f'NOT TAKEN OVER: the fleet manager does not answer ({error})'
        if self._graphs is None:
            self._graphs = GraphTopic('/graph')
        self._graphs.publish(draft)
        return ('Taken over: there is no fleet manager, so the graph was published on /graph. '
                'A robot refuses changes of its route until the route has ended')


def _providers() -> List[str]:
    """Returns the names of the nodes that put graphs in force."""
    _, _, services = rosgraph.Master(rospy.get_name()).getSystemState()
    names: List[str] = dict(services).get(RELOAD, [])
    return names


def _reloaded(server: str, file: str) -> str:
    theirs = str(rospy.get_param(f'{server}/graph_file', ''))
    if os.path.realpath(theirs) != os.path.realpath(file):
        return f'NOT TAKEN OVER: the fleet manager uses {theirs}, but this file is {file}'
    answer = rospy.ServiceProxy(RELOAD, Trigger)()
    return f'{"Taken over" if answer.success else "NOT TAKEN OVER"}: {answer.message}'
