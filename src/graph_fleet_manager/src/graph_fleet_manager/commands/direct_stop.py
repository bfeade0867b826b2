"""The stop that `fleet stop` sends to the robots directly if the fleet manager does not answer.

Each robot gets a stop with the number 0. This number begins a new epoch, so the robot obeys no
order that was sent before. If the fleet manager hung and continues later, it finds this epoch in
the reports of the robots, and stops the fleet.
"""
from __future__ import annotations

import queue
import threading
import time
from typing import Callable, Dict, List, Mapping, NamedTuple, Tuple

import rosgraph
import rospy

from graph_fleet_manager.multimaster.peer_master import MasterApi, NoAnswer
from itrci_nav_msgs.msg import FleetState, TargetRoute
from node_lifecycle.log_file import init_node

PATIENCE = 8.0    # s; limit for the whole stop: rospy waits without end for a master that hangs
NAMES_IN = 0.5    # s; limit for the names in /fleet_state; the fleet manager may hang
REACHED_IN = 3.0  # s; limit for the connections to the robots
FLUSHED_IN = 0.3  # s; time for the messages to reach the robots over their connections
_ROUTE = '/target_route'


class StopResult(NamedTuple):
    """Names of the robots that were told to stop, and of the robots without a connection."""

    told: Tuple[str, ...]
    missed: Tuple[str, ...]


def stop_robots(master_uri: str) -> StopResult:
    """Tells every robot to stop. Raises NoAnswer if the ROS master does not answer."""
    topics = MasterApi(master_uri).topic_types()
    done: queue.Queue[StopResult] = queue.Queue(1)
    troubles: List[str] = []

    def work() -> None:
        try:
            done.put(_stop(topics))
        except (OSError, rosgraph.MasterException, rospy.ROSException) as error:
            troubles.append(str(error))
            done.put(StopResult((), ()))
    threading.Thread(target=work, name='direct stop', daemon=True).start()
    try:
        result = done.get(timeout=PATIENCE)
    except queue.Empty:
        raise NoAnswer(f'it hangs for {PATIENCE:.0f} s') from None
    if troubles:
        raise NoAnswer(troubles[0])
    return result


def _stop(topics: Mapping[str, str]) -> StopResult:
    if not rospy.core.is_initialized():
        init_node('fleet_stop', anonymous=True, disable_signals=True)
    names = _fleet() or robots_of(topics)
    message = TargetRoute()
    message.header.stamp = rospy.Time.now()
    routes: Dict[str, rospy.Publisher] = {}
    for name in names:
        routes[name] = rospy.Publisher(f'/{name}{_ROUTE}', TargetRoute, queue_size=1, latch=True)
        routes[name].publish(message)

    def missed() -> List[str]:
        return [name for name, route in routes.items() if not route.get_num_connections()]
    _wait(lambda: not missed(), REACHED_IN)
    time.sleep(FLUSHED_IN)
    left = missed()
    for route in routes.values():
        route.unregister()  # otherwise a robot that connects later would be stopped
    return StopResult(tuple(name for name in routes if name not in left), tuple(left))


def _fleet() -> List[str]:
    """Returns the robots in /fleet_state; empty if the fleet manager does not publish it now."""
    found: List[FleetState] = []
    subscriber = rospy.Subscriber('/fleet_state', FleetState, found.append)
    _wait(lambda: bool(found), NAMES_IN)
    subscriber.unregister()
    return [robot.name for robot in found[-1].robots] if found else []


def robots_of(topics: Mapping[str, str]) -> List[str]:
    """Returns the robots that have a topic for routes; `topics` has the type of each topic."""
    return sorted(topic[1:-len(_ROUTE)] for topic, kind in topics.items()
                  if kind == TargetRoute._type and topic.endswith(_ROUTE) and topic != _ROUTE)


def _wait(condition: Callable[[], bool], seconds: float) -> None:
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.02)
