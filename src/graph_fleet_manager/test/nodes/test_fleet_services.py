"""The fleet stop works at once, even without a graph or a disk, or if the supervisor hangs."""
from __future__ import annotations

import math
import threading
import time

import genpy
import pytest
import rospy
from fleet_builders import AGV, corridor
from std_srvs.srv import TriggerRequest

from fleet_core.interlocking.stop_gate import StopGate
from fleet_core.supervision.early_stop import EarlyStop
from fleet_core.supervision.fleet_stop import NOT_STOPPED, FleetStop, StopCause
from fleet_core.supervision.hindrances import Hindrance
from fleet_core.supervision.missions import MissionState
from fleet_core.supervision.outages import Outage
from fleet_core.supervision.waits import WaitCode
from fleet_simulation.virtual_fleet import route_order
from graph_fleet_manager.messages.missions import state_message, stop_of
from graph_fleet_manager.nodes import fleet_services
from graph_fleet_manager.nodes.event_loop import SupervisorEvents
from itrci_nav_msgs.msg import FleetStop as FleetStopMessage
from itrci_nav_msgs.msg import RobotHindrance
from itrci_nav_msgs.srv import (
    ExplainMissionRequest,
    ExplainMissionResponse,
    GetMissionStatusRequest,
)
from route_protocol.master import REPEAT
from world.supervised_fleet import SupervisedFleet


class Services:
    """The services of a fleet by name, as threads of rospy call them."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, robots=('a', 'b')) -> None:
        self.handlers, self.past = {}, []
        # The clock stands still, so no tick becomes due and runs before a command.
        self.loop, self.early = SupervisorEvents(lambda: 0.0), EarlyStop(robots)
        monkeypatch.setattr(fleet_services.rospy, 'Service',
                            lambda name, _, handler: self.handlers.setdefault(name, handler))
        monkeypatch.setattr(fleet_services, 'STOP_PATIENCE', 60.0)
        self.gate = StopGate()
        fleet_services.FleetServices(robots, self.gate, self.loop,
                                     lambda now, stop: (' Early.', self.early.stop(now, stop)),
                                     lambda _, stop: self.past.append(stop))

    def call(self, name, supervisor=None, hangs=False, request=None):
        """Calls a service. Returns its answer, and the actions for the supervisor's thread."""
        answers, actions = [], []

        def ask():
            try:
                answers.append(self.handlers[name](request or TriggerRequest()))
            except rospy.ServiceException as error:
                answers.append(error)
        caller = threading.Thread(target=ask)
        caller.start()
        while not hangs and not answers:
            actions += self.loop.next_event()(supervisor, 0.0)
        caller.join()
        return answers[0], actions


@pytest.fixture
def services(monkeypatch):
    return Services(monkeypatch)


STOP = FleetStop(StopCause.PERSON, 'anna', 1e9)


def stops_of(actions):
    return sorted((order.robot, order.edges) for order in actions)


def test_a_stop_does_not_wait_for_a_graph(services):
    answer, actions = services.call('/stop_fleet')
    assert answer.success and answer.message == 'Every robot was told to stop. Early.'
    assert stops_of(actions) == [('a', ()), ('b', ())]
    assert services.past == []


def test_the_log_tells_who_was_stopped_and_who_goes_on(services, monkeypatch):
    """The log is the only record of what a person did to the whole fleet."""
    logged = []
    monkeypatch.setattr(fleet_services.rospy, 'loginfo', lambda text, *words: logged.append(
        text % words))
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    for name in ('/stop_fleet', '/resume_fleet'):
        services.call(name, fleet.supervisor)
    assert logged == ['/stop_fleet: Every robot was told to stop.',
                      f'/resume_fleet: {fleet.supervisor.who_goes_on}']
    del logged[:]
    services.call('/resume_fleet')
    assert logged == ['/resume_fleet: not done: the fleet manager has no graph yet, its work '
                      'file does not fit the graph, or its disk cannot be written: see '
                      '/diagnostics']


def request_from(**header):
    request = TriggerRequest()
    request._connection_header = header
    return request


@pytest.mark.parametrize('header, by', [
    ({'callerid': '/rosservice'}, '/rosservice'), ({}, ''),
    ({'callerid': '/fleet_stop', 'requested_by': 'anna (page)'}, 'anna (page)'),
    ({'callerid': 300 * 'x' + '\n'}, 256 * 'x')])
def test_who_stops_the_fleet_is_recorded_by_the_header_of_the_call(services, header, by):
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    services.call('/stop_fleet', fleet.supervisor, request=request_from(**header))
    stop = fleet.supervisor.stop
    assert (stop.cause, stop.by) == (StopCause.PERSON, by)
    assert abs(stop.since - time.time()) < 60.0
    message = state_message((), (), (), stop, None, genpy.Time(1), {})
    told = stop_of(message.stop)
    assert (told.by, told.since) == (by, pytest.approx(stop.since))
    message = state_message((), (), (), NOT_STOPPED, None, genpy.Time(1), {})
    assert stop_of(message.stop) == NOT_STOPPED


def test_a_cause_of_a_later_version_is_a_stop():
    assert stop_of(FleetStopMessage(cause=99)) == FleetStop(StopCause.UNKNOWN)


@pytest.mark.parametrize('cause', StopCause)
def test_the_causes_have_the_numbers_of_the_message(cause):
    assert getattr(FleetStopMessage, cause.name) == cause


def resumed(fleet):
    """Resumes a fleet. Returns why that failed, and the text for people if it succeeded."""
    problem, actions = fleet.supervisor.resume_fleet(fleet.now)
    fleet.do(actions)
    return problem, fleet.supervisor.who_goes_on


def test_a_resume_is_done_and_names_the_robots_that_stay():
    """A person who reads `not done` believes that no robot drives."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.request(1, 3, robot='a')
    fleet.run(2.0)
    fleet.do(fleet.supervisor.take_out('b', fleet.now))
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    assert resumed(fleet) == ('', 'The fleet goes on, except b: it was taken out of service.')
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_resume_by_which_no_robot_goes_on_says_so():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.run(1.0)
    for name in 'ab':
        fleet.do(fleet.supervisor.take_out(name, fleet.now))
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    assert resumed(fleet) == ('', 'The stop is released, but no robot goes on: a: it was taken out '
                                  'of service; b: it was taken out of service.')
    assert not fleet.supervisor.is_stopped


def test_a_resume_while_a_robot_that_never_reported_holds_all_others_says_so():
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.network.silent['b'] = math.inf
    fleet.run(1.0)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    problem, told = resumed(fleet)
    assert not problem and 'no robot goes on before b report' in told


def test_the_service_tells_who_goes_on_and_that_it_is_done(services):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.do(services.call('/stop_fleet', fleet.supervisor)[1])
    answer, _ = services.call('/resume_fleet', fleet.supervisor)
    assert answer.success and answer.message == fleet.supervisor.who_goes_on


def test_a_resume_after_which_the_fleet_was_stopped_again_is_not_done(services):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.do(services.call('/stop_fleet', fleet.supervisor)[1])
    fleet.supervisor.gate.close()
    answer, _ = services.call('/resume_fleet', fleet.supervisor)
    assert not answer.success and 'stopped again' in answer.message


def test_an_early_stop_is_repeated_until_the_supervisor_takes_over():
    early = EarlyStop(['a'])
    assert early.due(0.0) == () and not early.hand_over()
    order, = early.stop(10.0, STOP)
    assert early.due(10.0 + REPEAT / 2) == ()
    again, = early.due(10.0 + REPEAT)
    assert (again.robot, again.order) == (order.robot, order.order)
    assert order.order.number == 0 and order.edges == ()
    assert again.repeated and not order.repeated
    assert early.hand_over() == STOP and early.hand_over() is None
    assert early.due(99.0) == ()


@pytest.mark.parametrize('dies', [True, False])
def test_a_robot_stopped_early_goes_on_with_its_mission_after_a_resume(dies):
    """Either this process begins to supervise, or it is killed after it has stored the stop."""
    fleet = SupervisedFleet(corridor(6), {'a': (AGV, 1)})
    fleet.request(1, 6)
    fleet.run(3.0)
    fleet.disk.journal.store(stop=STOP)
    fleet.agvs['a'].receive(route_order(EarlyStop('a').stop(0.0, STOP)[0].order))
    fleet.restart()
    if not dies:
        fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.run(5.0)
    assert not fleet.agvs['a'].is_driving and fleet.state(1).is_open
    problem, actions = fleet.supervisor.resume_fleet(fleet.now)
    fleet.do(actions)
    assert not problem
    fleet.run_until_done(1)
    assert fleet.agvs['a'].visited[-1] == 6


def test_a_stop_goes_past_a_supervisor_that_hangs_and_is_kept_for_it(services, monkeypatch):
    monkeypatch.setattr(fleet_services, 'STOP_PATIENCE', 0.1)
    answer, _ = services.call('/stop_fleet', hangs=True)
    assert answer.success and 'hangs' in answer.message and len(services.past) == 1
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    services.loop.next_event()(fleet.supervisor, 0.0)
    assert fleet.supervisor.is_stopped


def stop_past(fleet):
    for order in EarlyStop(['a', 'b']).stop(0.0, STOP):
        fleet.agvs[order.robot].receive(route_order(order.order))


def test_a_stop_that_bypasses_the_supervisor_lasts_if_the_supervisor_is_killed():
    """The stop is not on the disk, but the robots report it."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.request(1, 3, robot='a')
    fleet.run_until_done(1)
    stop_past(fleet)
    fleet.request(2, 5, robot='a')
    fleet.restart()
    travelled = fleet.agvs['a'].travelled
    fleet.run(8.0)
    assert fleet.supervisor.is_stopped and fleet.agvs['a'].travelled == travelled
    stop = fleet.supervisor.stop
    assert stop.cause is StopCause.BYPASSED and 'was stopped by a command' in stop.why
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(2)
    fleet.restart()
    fleet.run(6.0)
    assert not fleet.supervisor.is_stopped


@pytest.mark.parametrize('dies', [True, False])
def test_who_was_stopped_on_its_way_past_a_supervisor_goes_on_after_a_resume(dies):
    """The robot has not forgotten its route, so it needs no person."""
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.request(1, 5, robot='a')
    fleet.run(3.0)
    stop_past(fleet)
    if dies:
        fleet.restart()
    fleet.run(8.0)
    assert fleet.supervisor.is_stopped and fleet.supervisor.robots['a'].outage is None
    problem, actions = fleet.supervisor.resume_fleet(fleet.now)
    fleet.do(actions)
    assert not problem
    fleet.run_until_done(1)
    assert fleet.agvs['a'].visited[-1] == 5


def test_what_else_is_asked_for_without_a_graph_is_not_done(services):
    for name in ('/resume_fleet', '/a/leave_fleet', '/a/join_fleet'):
        answer, actions = services.call(name)
        assert not answer.success and 'no graph yet' in answer.message and actions == []


def test_a_stop_that_cannot_be_stored_is_done_and_that_is_said(services):
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    fleet.disk.fails()
    fleet.request(1, 2)
    answer, actions = services.call('/stop_fleet', fleet.supervisor)
    assert answer.success and 'forgotten: the journal' in answer.message
    assert ('a', ()) in [(order.robot, order.edges) for order in actions if hasattr(order, 'robot')]


@pytest.mark.parametrize('name', ['/resume_fleet', '/a/join_fleet'])
def test_what_was_not_done_in_time_is_not_done_later(services, monkeypatch, name):
    """The caller was told that the robots do not go on, and may stand among them later."""
    monkeypatch.setattr(fleet_services, 'PATIENCE', 0.1)
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    fleet.run(3.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(3.0)
    if name == '/resume_fleet':
        fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    answer, _ = services.call(name, hangs=True)
    assert not answer.success and 'and it will not be done' in answer.message
    assert services.loop.next_event()(fleet.supervisor, fleet.now) == ()
    assert not fleet.supervisor.robots['a'].works
    assert fleet.supervisor.is_stopped == (name == '/resume_fleet')


def test_a_robot_that_was_not_taken_out_in_time_is_taken_out_later(services, monkeypatch):
    monkeypatch.setattr(fleet_services, 'PATIENCE', 0.1)
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    answer, _ = services.call('/a/leave_fleet', hangs=True)
    assert not answer.success and 'but it will be done' in answer.message
    assert services.loop.next_event()(fleet.supervisor, fleet.now)
    assert fleet.supervisor.robots['a'].outage is Outage.OUT_OF_SERVICE


def test_the_stored_status_of_a_mission_is_told_to_a_program_that_asks(services, monkeypatch):
    monkeypatch.setattr(fleet_services.rospy, 'Time', FixedTime)
    fleet = SupervisedFleet(corridor(3), {'a': (AGV, 1), 'b': (AGV, 3)})
    fleet.request(7, 2)
    ask = GetMissionStatusRequest(request_id=7)
    answer, _ = services.call('/get_mission_status', fleet.supervisor, request=ask)
    assert (answer.found, answer.status.request_id) == (True, 7)
    assert MissionState(answer.status.state).is_open
    ask.request_id = 8
    answer, _ = services.call('/get_mission_status', fleet.supervisor, request=ask)
    assert not answer.found


def test_what_a_mission_waits_for_is_told_to_a_program_that_asks(services):
    fleet = SupervisedFleet(corridor(8), {'a': (AGV, 1), 'b': (AGV, 8)})
    fleet.run(1.0)
    fleet.request(7, 6, robot='a')
    fleet.run(1.0)
    fleet.request(8, 2, robot='a')
    fleet.run(1.0)
    told, _ = services.call('/explain_mission', fleet.supervisor,
                            request=ExplainMissionRequest(request_id=8))
    assert (told.found, told.waits_for_code, told.waits_for) == (
        True, told.ROBOT, 'it waits for a to be free')
    busy, other = told.robots
    assert (busy.robot, busy.hindrance, busy.has_mission, busy.request_id) == (
        'a', busy.BUSY, True, 7)
    assert busy.until == told.until and 0.0 < told.until < 20.0
    assert (other.robot, other.hindrance, other.has_mission) == ('b', busy.OTHER_ROBOT, False)
    told, _ = services.call('/explain_mission', fleet.supervisor,
                            request=ExplainMissionRequest(request_id=9))
    assert not told.found


@pytest.mark.parametrize('kind, message', [
    (Hindrance, RobotHindrance), (WaitCode, ExplainMissionResponse)])
def test_the_reasons_have_the_numbers_of_the_message(kind, message):
    assert {one.name: getattr(message, one.name) for one in kind} == {
        one.name: one.value for one in kind}


def test_before_the_fleet_manager_has_begun_no_mission_is_called_unknown(services):
    answer, _ = services.call('/get_mission_status', request=GetMissionStatusRequest(request_id=7))
    assert isinstance(answer, rospy.ServiceException) and 'no graph yet' in str(answer)


class FixedTime:
    """A clock for messages without ROS."""

    now = staticmethod(lambda: genpy.Time(5))
