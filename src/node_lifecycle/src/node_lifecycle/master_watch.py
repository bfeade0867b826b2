"""Registers the node and its parameters again after a restart of the ROS master.

Without this module, a node keeps its present connections, but new nodes cannot find it. To check,
this module asks the master for a service of the node, not for the node itself: rospy reads a
parameter at each log line, which makes a new master know the node, but not its topics and services.
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
    """The registrations of a node at a ROS master. If there is no master, each call raises."""

    def is_known(self) -> bool:
        """Returns whether the master knows one registration of the node; this query is cheap."""

    def restore(self) -> None:
        """Sets the node's parameters that the master lacks, and repeats all registrations."""

    def is_complete(self) -> bool:
        """Returns whether the master knows all registrations of the node."""


class MasterWatch:
    """Checks repeatedly whether the master knows this node.

    A master may end while the node registers. So the registrations are repeated until the master
    knows all of them.
    """

    def __init__(self, node: NodeAtMaster) -> None:
        self._node = node
        self._is_complete = True

    def start(self) -> None:
        """Begins to check, in a separate thread."""
        threading.Thread(target=self._run, name='master watch', daemon=True).start()

    def register_again(self) -> bool:
        """Registers the node again if the master works but lacks the node.

        Returns whether this call has completed the registration.
        """
        try:
            if self._is_complete and self._node.is_known():
                return False
            self._is_complete = False
            self._node.restore()
            self._is_complete = self._node.is_complete()
        except (OSError, http.client.HTTPException, xmlrpc.client.Error, rosgraph.MasterException):
            return False  # there is no master now
        return self._is_complete

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            if not rospy.is_shutdown() and self.register_again():
                rospy.logwarn('The ROS master did not know this node any more, as after a restart: '
                              'the node has registered again and has set its parameters again.')


def watch_master() -> None:
    """Keeps this node registered until it ends."""
    MasterWatch(ThisNode(rosgraph.Master(rospy.get_name()), KEPT)).start()


class ThisNode:
    """The node of this process."""

    def __init__(self, master: rosgraph.Master, parameters: KeptParameters) -> None:
        self._master = master
        self._parameters = parameters
        self._service = rospy.resolve_name('~get_loggers')  # a service of every rospy node

    def is_known(self) -> bool:
        """See NodeAtMaster."""
        try:
            self._master.lookupService(self._service)
        except rosgraph.MasterError:
            return False
        return True

    def restore(self) -> None:
        """See NodeAtMaster. Sets parameters first, because a registered node counts as complete."""
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
    """Returns the kind, the name, and the type or URI of each registration that rospy has for this
    node.
    """
    topics, services = get_topic_manager(), get_service_manager()
    return {(kind, name, type_or_uri) for kind, entries in (
        (Registration.PUB, topics.get_publications()),
        (Registration.SUB, topics.get_subscriptions()),
        (Registration.SRV, services.get_services())) for name, type_or_uri in entries}
