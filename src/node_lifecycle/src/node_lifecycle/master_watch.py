"""Registers the node anew when the ROS master was restarted and does not know it any more.

Without this a node goes on with whom it knows already, and nobody new finds it. Parameters are lost
with the old master, but the nodes have read theirs.
"""
from __future__ import annotations

import http.client
import threading
import time
import xmlrpc.client
from typing import Callable

import rosgraph
import rospy
from rospy.impl.registration import (
    Registration,
    get_registration_listeners,
    get_service_manager,
    get_topic_manager,
)

PERIOD = 3.0  # s


class MasterWatch:
    """Asks the master again and again whether it knows this node."""

    def __init__(self, is_known: Callable[[], bool], register: Callable[[], None]) -> None:
        self._is_known = is_known
        self._register = register

    def start(self) -> None:
        """Begins to ask, in a thread of its own."""
        threading.Thread(target=self._run, name='master watch', daemon=True).start()

    def look(self) -> bool:
        """Registers the node if the master is there and does not know it; whether it did."""
        try:
            if self._is_known():
                return False
            self._register()
        except (OSError, http.client.HTTPException, xmlrpc.client.Error):
            return False  # the master is not there now
        return True

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(PERIOD)
            if not rospy.is_shutdown() and self.look():
                rospy.logwarn('The ROS master did not know this node any more, as after a restart: '
                              'the node has registered anew. Parameters that were set in the old '
                              'master are lost.')


def watch_master() -> None:
    """Keeps this node registered until it ends."""
    master = rosgraph.Master(rospy.get_name())

    def is_known() -> bool:
        try:
            master.lookupNode(rospy.get_name())
        except rosgraph.MasterError:
            return False
        return True

    MasterWatch(is_known, _register_anew).start()


def _register_anew() -> None:
    """Everything that rospy registered with the master before, by rospy's own registrar."""
    listeners = get_registration_listeners()
    topics, services = get_topic_manager(), get_service_manager()
    for kind, registered in ((Registration.PUB, topics.get_publications()),
                             (Registration.SUB, topics.get_subscriptions()),
                             (Registration.SRV, services.get_services())):
        for name, type_or_uri in registered:
            listeners.notify_added(name, type_or_uri, kind)
