"""path_planner: plans the paths of all robots, without conflicts even if robots are late.

It answers one request at a time, and between requests it keeps only the graph. It can be ended at
any time: its client continues. Requests and answers: docs/reference/path_planner.md.

Subscribes
    /graph (itrci_nav_msgs/Graph, latched), /parking (itrci_nav_msgs/ParkingPlaces, latched)
    /plan_request (itrci_nav_msgs/PlanRequest)
Publishes
    /plan_answer (itrci_nav_msgs/PlanAnswer, latched): one for each request
    /diagnostics
Parameters
    ~fleet_file          string  (required)  fleet file (YAML)
    ~search              string  safe_intervals  or layers, the dissertation's TEA*
    ~layer_length        float   1.0 s   time between two layers
    ~seed                int     0       seed of all random numbers
    ~time_limit          float   2.0 s   time limit of requests that give none
    ~longest_time_limit  float   10.0 s  longest time limit of any request
    ~sim_speed           float   1.0     factor by which simulated robots are faster
"""
from __future__ import annotations

import threading
import time
import traceback
from dataclasses import replace
from typing import Optional, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.planning.layers import layered
from fleet_core.planning.plan_requests import Times
from fleet_core.planning.plan_service import PlanService
from fleet_core.planning.safe_intervals import find_path
from fleet_core.planning.tasks import CannotPlan
from graph_fleet_manager.messages.edge_times import TimesKept
from graph_fleet_manager.messages.planning import answer_message, no_plan_message, request_of
from graph_fleet_manager.nodes.fleet_parameter import fleet_of
from graph_topic import FollowedGraph
from itrci_nav_msgs.msg import ParkingPlaces, PlanAnswer, PlanRequest
from node_lifecycle import choice, number, parameter, publish_diagnostics, run
from trajectory_graph import Graph

_WAITING = 20  # requests in the queue at most; only the newest request that waits is planned


class PathPlanner:
    """The node; see the docstring of the module. One thread plans; callbacks only queue requests.

    The attributes are the parameters, the newest input of each topic, and the state of the service.
    """

    def __init__(self) -> None:
        self._fleet = fleet_of()
        self._types = {kind.name: kind for kind in self._fleet.types}
        search = choice('~search', 'safe_intervals', ('safe_intervals', 'layers'))
        layer_length = number('~layer_length', 1.0, 0.05, 60.0)
        self._search = find_path if search == 'safe_intervals' else layered(layer_length)
        self._seed: int = parameter('~seed', 0, int)
        self._time_limit = number('~time_limit', 2.0, 0.01, 600.0)
        self._longest = number('~longest_time_limit', 10.0, self._time_limit, 600.0)
        self._rate = number('~sim_speed', 1.0, 0.01, 100.0)
        self._changed = threading.Condition()
        self._new_graph: Optional[Tuple[Graph, rospy.Time]] = None
        self._request: Optional[Tuple[PlanRequest, Times]] = None
        self._times = TimesKept()
        self._received = 0.0
        self._parking: Optional[ParkingPlaces] = None
        self._service: Optional[PlanService] = None
        self._stamp = rospy.Time(0)
        """Version of the graph of `_service`."""
        self._status = (DiagnosticStatus.WARN, 'waiting for /graph')
        self._figures = {'planning time': '', 'robots': '', 'unserved': ''}
        self._answers = rospy.Publisher('/plan_answer', PlanAnswer, queue_size=10, latch=True)
        publish_diagnostics('none', {'planner': self._report})
        threading.Thread(target=self._work, name='planner', daemon=True).start()
        self._subscribers = [
            FollowedGraph(self._on_graph, each=True, on_refused=self._on_refused).subscribe(),
            rospy.Subscriber('/parking', ParkingPlaces, self._on_parking, queue_size=1),
            rospy.Subscriber('/plan_request', PlanRequest, self._on_request,
                             queue_size=_WAITING, tcp_nodelay=True)]

    # -- callbacks --------------------------------------------------------------------------------

    def _on_graph(self, graph: Graph, stamp: rospy.Time) -> None:
        with self._changed:
            self._new_graph = graph, stamp
            self._changed.notify()

    def _on_refused(self, problem: str) -> None:
        self._status = DiagnosticStatus.ERROR, f'a /graph that is not valid: {problem}'

    def _on_parking(self, message: ParkingPlaces) -> None:
        with self._changed:
            self._parking = message

    def _on_request(self, message: PlanRequest) -> None:
        with self._changed:
            times = self._times.table_of(message, self._rate)
        if times is None:
            self._answers.publish(self._told(
                message, PlanAnswer.OTHER_TIMES,
                'Its learned times are changes to times that are not known here; ask again with '
                'all of them.'))
            return
        with self._changed:
            older, self._request = self._request, (message, times)
            self._received = time.monotonic()
            self._changed.notify()
        if older is not None and not _is_same(older[0], message):
            self._answers.publish(no_plan_message(older[0], PlanAnswer.SUPERSEDED,
                                                  'A newer request came.'))

    # -- the planning thread ----------------------------------------------------------------------

    def _work(self) -> None:
        try:
            self._plan_until_the_end()
        except Exception:  # a planner without answers must not seem to work: the node ends
            rospy.logfatal('The planning thread has failed; please report this:\n%s',
                           traceback.format_exc())
            rospy.signal_shutdown('the planning thread has failed')

    def _plan_until_the_end(self) -> None:
        while not rospy.is_shutdown():
            with self._changed:
                if self._new_graph is None and self._request is None:
                    self._changed.wait(0.5)
                graph, self._new_graph = self._new_graph, None
                if graph is None:
                    request, self._request = self._request, None
                    received = self._received
            if graph is not None:
                self._prepare(*graph)
            elif request is not None:
                self._answers.publish(self._answer(*request, received))

    def _prepare(self, graph: Graph, stamp: rospy.Time) -> None:
        service = PlanService(graph, self._fleet, self._search, self._seed)
        begun = time.monotonic()
        service.prepare()
        self._service, self._stamp = service, stamp
        self._status = DiagnosticStatus.OK, f'ready, {len(service.graph.edges)} edges'
        rospy.loginfo('Ready to plan on %d vertices and %d edges; the exclusions took %.3f s.',
                      len(service.graph.vertices), len(service.graph.edges),
                      time.monotonic() - begun)

    def _answer(self, request: PlanRequest, times: Times, received: float) -> PlanAnswer:
        service = self._service
        if service is None or request.graph_stamp != self._stamp:
            return self._told(request, PlanAnswer.OTHER_GRAPH,
                              'There is no /graph yet.' if service is None else
                              'The request is about another version of /graph; ask again with the '
                              'header.stamp of the one in force.')
        begun = time.monotonic()
        try:
            asked = request_of(request, self._types, times, self._time_limit, self._longest,
                               self._rate)
            if not asked.parking:
                asked = replace(asked, parking=self._known_parking(service))
            outcome = service.answer(asked, received)
        except CannotPlan as refusal:
            return self._told(request, PlanAnswer.REFUSED, str(refusal))
        except Exception:  # a defect: the client needs an answer; the next request may succeed
            rospy.logerr('A request could not be planned because of a defect of the planner; '
                         'please report it with this text:\n%s', traceback.format_exc())
            return self._told(request, PlanAnswer.REFUSED, 'The planner failed because of a '
                              'defect; report the text in its log, and send another request.')
        took = time.monotonic() - begun
        self._figures = {
            'planning time': f'{took:.3f} s', 'robots': str(len(request.tasks)),
            'unserved': '; '.join(f'{name}: {why}' for name, why in outcome.unserved.items())}
        self._status = DiagnosticStatus.OK, f'planned for {len(request.tasks)} robots'
        return answer_message(request, outcome, took, self._rate)

    def _known_parking(self, service: PlanService) -> frozenset:
        parking = self._parking
        if parking is not None and parking.header.stamp == self._stamp:
            return frozenset(parking.vertices)
        return service.parking_by_name()

    def _told(self, request: PlanRequest, result: int, reason: str) -> PlanAnswer:
        rospy.logwarn_throttle(10.0, f'Plan request {request.plan_id} was not planned: {reason}')
        self._status = DiagnosticStatus.WARN, f'the last request was not planned: {reason}'
        return no_plan_message(request, result, reason)

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        status.summary(*self._status)
        for name, value in self._figures.items():
            status.add(name, value)


def _is_same(one: PlanRequest, other: PlanRequest) -> bool:
    """Returns whether two messages are the same request.

    After a supervisor has connected, its open request can come twice.
    """
    return (one.plan_id, one.header.stamp) == (other.plan_id, other.header.stamp)


def main() -> None:
    """Runs the node."""
    run('path_planner', PathPlanner)
