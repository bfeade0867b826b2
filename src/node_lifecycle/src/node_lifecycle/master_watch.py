"""Registers the node anew when the ROS master was restarted, and sets its parameters again.

Without this a node goes on with the nodes that it is connected with already, and no new one finds
it. The master is asked for a service of the node, not for the node: rospy asks for a parameter at
each line of the log, and thereby makes a new master know the node without its topics and services.
"""
from __future__ import annotations

import http.client
import threading
import time
import xmlrpc.client
from typing import Protocol, Set, Tuple

import rosgraph
import rospy
from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

from node_lifecycle.kept_parameters import KEPT, KeptParameters

PERIOD = 3.0  # s


class NodeAtMaster(Protocol):
    """What a ROS master has of a node. Each call raises where the master is not there."""

    def is_known(self) -> bool:
        """Does the master know a registration of the node? Cheap."""

    def restore(self) -> None:
        """Sets the parameters of the node that the master lacks, and registers all anew."""

    def is_complete(self) -> bool:
        """Does the master know all registrations of the node?"""


class MasterWatch:
    """Asks the master again and again whether it knows this node.

    A master may end while the node registers: only what was complete once needs no second try.
    """

    def __init__(self, node: NodeAtMaster) -> None:
        self._node = node
        self._is_complete = True

    def start(self) -> None:
        """Begins to ask, in a thread of its own."""
        threading.Thread(target=self._run, name='master watch', daemon=True).start()

    def look(self) -> bool:
        """Registers the node if the master is there and lacks it; whether all is there now that
        was not."""
        try:
            if self._is_complete and self._node.is_known():
                return False
            self._is_complete = False
            self._node.restore()
            self._is_complete = self._node.is_complete()
        except (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterException):
            return False  # the master is not there now
        return self._is_complete

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            if not rospy.is_shutdown() and self.look():
                rospy.logwarn('The ROS master did not know this node any more, as after a restart: '
                              'the node has registered anew, and has set its parameters again.')


def watch_master() -> None:
    """Keeps this node registered until it ends."""
    MasterWatch(ThisNode(rosgraph.Master(rospy.get_name()), KEPT)).start()


class ThisNode:
    """The node of this process."""

    def __init__(self, master: rosgraph.Master, parameters: KeptParameters) -> None:
        self._master = master
        self._parameters = parameters
        self._service = rospy.resolve_name('~get_loggers')  # which every node of rospy has

    def is_known(self) -> bool:
        """See NodeAtMaster."""
        try:
            self._master.lookupService(self._service)
        except rosgraph.MasterError:
            return False
        return True

    def restore(self) -> None:
        """See NodeAtMaster. Parameters come first: a registered node counts as complete."""
        self._parameters.set_missing(self._master)
        listeners = get_registration_listeners()
        for kind, name, type_or_uri in _registrations():
            listeners.notify_added(name, type_or_uri, kind)

    def is_complete(self) -> bool:
        """See NodeAtMaster."""
        own = rospy.get_name()
        kinds = (Registration.PUB, Registration.SUB, Registration.SRV)
        there = {(kind, name) for kind, entries in zip(kinds, self._master.getSystemState())
                 for name, nodes in entries if own in nodes}
        return all((kind, name) in there for kind, name, _ in _registrations())


def _registrations() -> Set[Tuple[str, str, str]]:
    """Kind, name, and type or URI of all that rospy has registered for this node."""
    topics, services = get_topic_manager(), get_service_manager()
    return {(kind, name, type_or_uri) for kind, entries in (
        (Registration.PUB, topics.get_publications()),
        (Registration.SUB, topics.get_subscriptions()),
        (Registration.SRV, services.get_services())) for name, type_or_uri in entries}
