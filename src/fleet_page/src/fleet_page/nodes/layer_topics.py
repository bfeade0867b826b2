"""The topics of layers. They are received only while a browser shows the layer."""
from __future__ import annotations

import concurrent.futures
import time
from typing import Any, Callable, Dict, FrozenSet

import rospy
from sensor_msgs.msg import PointCloud2

from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.layers import ALLOCATION, LASER
from fleet_page.nodes import messages
from itrci_nav_msgs.msg import FleetAllocations
from node_lifecycle import warn

PERIOD = 0.4  # s between two scans that are shown


class LayerTopics:
    """The subscribers. The thread of the event loop calls `watch`.

    call -- calls a function with values in the thread of the event loop

    The ROS master may be slow. So a separate thread asks it.
    """

    def __init__(self, model: FleetModel, call: Callable[..., None]) -> None:
        self._model, self._call = model, call
        self._subscribers: Dict[str, rospy.Subscriber] = {}
        self._wanted: FrozenSet[str] = frozenset()
        self._thread = concurrent.futures.ThreadPoolExecutor(1, 'layers')
        self._shown: Dict[str, float] = {}

    def watch(self, sources: FrozenSet[str]) -> None:
        """Receives these sources (ShownLayers.sources) only."""
        for source in self._wanted - sources:
            self._hide(source)
        if sources != self._wanted:
            self._wanted = sources
            self._thread.submit(self._follow)

    def _hide(self, source: str) -> None:
        if source == ALLOCATION:
            self._model.show_allocations({})
        else:
            self._model.hide_laser(source.partition(':')[2])

    def _show(self, source: str, show: Callable[..., None], *values: Any) -> None:
        if source in self._wanted:  # a late message is dropped
            show(*values)

    # -- the thread that asks the ROS master ------------------------------------------------------

    def _follow(self) -> None:
        sources = self._wanted
        for source in self._subscribers.keys() - sources:
            self._subscribers.pop(source).unregister()
        for source in sources - self._subscribers.keys():
            self._subscribers[source] = self._subscribed(source)

    def _subscribed(self, source: str) -> rospy.Subscriber:
        if source == ALLOCATION:
            return rospy.Subscriber('/fleet_allocations', FleetAllocations, self._on_allocations,
                                    queue_size=1)
        robot = source.partition(':')[2]
        return rospy.Subscriber(f'/{robot}/laser_cloud', PointCloud2,
                                lambda cloud: self._on_cloud(robot, cloud), queue_size=1)

    # -- threads of rospy -------------------------------------------------------------------------

    def _on_allocations(self, message: FleetAllocations) -> None:
        self._call(self._show, ALLOCATION, self._model.show_allocations,
                   messages.allocations_of(message))

    def _on_cloud(self, robot: str, cloud: PointCloud2) -> None:
        source, now = f'{LASER}:{robot}', time.monotonic()
        if now - self._shown.get(source, -PERIOD) < PERIOD:
            return
        self._shown[source] = now
        try:
            points = messages.laser_of(cloud)
        except ValueError as wrong:
            warn(source, f'The laser of {robot} is not shown: {wrong}.')
            return
        self._call(self._show, source, self._model.show_laser, robot, points)
