"""How an edited graph becomes the one that robots drive on.

Where a fleet manager runs, it owns /graph: its `graph_server` reads the file again, or says which
robot drives on what has changed. Elsewhere the editor publishes /graph; a robot refuses it while
it drives on what has changed.
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
    """Puts drafts in force. Before the first one, this node does not offer /graph at all."""

    def __init__(self) -> None:
        self._graphs: Optional[GraphTopic] = None

    def put_in_force(self, draft: Draft, file: str) -> str:
        """Takes a draft over that `file` holds; returns what became of that, a sentence."""
        try:
            servers = _providers()
            if servers:
                return _reloaded(servers[0], file)
        except (rosgraph.MasterException, OSError, rospy.ServiceException) as error:
            return f'NOT TAKEN OVER: the fleet manager does not answer ({error})'
        if self._graphs is None:
            self._graphs = GraphTopic('/graph')
        self._graphs.publish(draft)
        return ('Taken over: there is no fleet manager, robots hear of the graph on /graph. '
                'Until its route has ended, a robot refuses what changes that')


def _providers() -> List[str]:
    """Names of the nodes that have a graph in force."""
    _, _, services = rosgraph.Master(rospy.get_name()).getSystemState()
    names: List[str] = dict(services).get(RELOAD, [])
    return names


def _reloaded(server: str, file: str) -> str:
    theirs = str(rospy.get_param(f'{server}/graph_file', ''))
    if os.path.realpath(theirs) != os.path.realpath(file):
        return f'NOT TAKEN OVER: the fleet manager drives on {theirs}, and this is {file}'
    answer = rospy.ServiceProxy(RELOAD, Trigger)()
    return f'{"Taken over" if answer.success else "NOT TAKEN OVER"}: {answer.message}'
