"""Requests and answers survive the conversion to messages and back; bad values are refused."""
from __future__ import annotations

from io import BytesIO

import genpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.fleet import RobotType
from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import Alone
from fleet_core.planning.plan_requests import PlanRequest
from fleet_core.planning.precedence import Constraint
from fleet_core.planning.tasks import CannotPlan, Obstacle, PlannedDrive, PlanningOutcome, Task
from fleet_core.supervision.laden_types import LadenTypes
from fleet_core.work.loads import LoadType
from graph_fleet_manager.messages.planning import (
    WrongAnswer,
    answer_message,
    no_plan_message,
    outcome_of,
    request_message,
    request_of,
)
from itrci_nav_msgs import msg

AGV = RobotType('agv', 0.4, 1.0)
TYPES = {'agv': AGV}
LADEN = LadenTypes({'pallet': LoadType('pallet', 0.7, 0.6, frozenset({12})),
                    'box': LoadType('box', 0.5)}, [AGV]).types
STAMP = genpy.Time(1700000000, 123456789)
GRAPH = genpy.Time(1600000000)

ids = st.integers(1, 2**31 - 1)
signed = ids | ids.map(lambda id: -id)
seconds = st.integers(0, 10**7).map(lambda ms: ms / 1000.0)
fractions = st.floats(0.0, 0.999)
drives = st.lists(st.builds(PlannedDrive, signed, seconds, seconds), max_size=3).map(tuple)
metres = st.floats(-1e6, 1e6)
areas = st.builds(Area, st.lists(st.tuples(metres, metres), min_size=1, max_size=3).map(tuple),
                  st.floats(0.0, 1e3))
places = st.one_of(
    st.fixed_dictionaries({'vertex': ids}),
    st.fixed_dictionaries({'released': st.lists(signed, min_size=1, max_size=3).map(tuple),
                           'begun': fractions}),
    st.fixed_dictionaries({'mid_edge': st.tuples(signed, fractions)}))


@st.composite
def tasks(draw, name):
    return Task(name, AGV, **draw(places), ready=draw(seconds),
                destinations=tuple(draw(st.lists(ids, max_size=2))),
                dwells=tuple(draw(st.lists(seconds, max_size=2))), stays=draw(st.booleans()),
                kept=draw(st.none() | drives), priority=draw(st.integers(-5, 5)))


requests = st.builds(
    PlanRequest, st.tuples(tasks('r1'), tasks('r2')),
    st.tuples(st.builds(Obstacle, st.just('r3'), st.just(AGV), st.tuples(ids), st.tuples(ids),
                        st.lists(areas, max_size=2).map(tuple))),
    st.frozensets(ids, max_size=3), st.dictionaries(st.tuples(st.just('agv'), signed), seconds),
    st.lists(st.builds(Alone, st.frozensets(ids), st.frozensets(ids)), max_size=2).map(tuple),
    st.frozensets(ids, max_size=3), st.floats(0.001, 10.0), st.floats(0.0, 10.0),
    st.integers(0, 2 ** 32 - 1), st.frozensets(ids, max_size=3), st.sampled_from(((), LADEN)))


def outlined(x, y, radius=0.0):
    """Returns a request with one obstacle that has one outline."""
    return msg.PlanRequest(obstacles=[msg.FleetObstacle(
        robot='r1', robot_type='agv', outlines=[msg.Outline(x, y, radius)])])


def laden(name, robot_type, radius, speed):
    """Returns the laden type of a request."""
    return msg.LadenType(name, robot_type, radius, speed, [])


def through_ros(message):
    """Returns the message as a subscriber gets it."""
    buffer = BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


def close(one, other):
    """Returns whether both are equal within the precision of ROS times (1 ns) and of floats."""
    if isinstance(one, float):
        return other == pytest.approx(one, abs=2e-8)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(close, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(close(one[key], other[key]) for key in one)
    if hasattr(one, '__dict__') and not isinstance(one, RobotType):
        return close(vars(one), vars(other))
    return one == other


class TestRequests:
    @given(requests, st.sampled_from((1.0, 5.0)))
    def test_arrive_as_they_were_sent(self, request, rate):
        message = through_ros(request_message(request, 7, STAMP, GRAPH, rate))

        assert (message.plan_id, message.header.stamp, message.graph_stamp) == (7, STAMP, GRAPH)
        assert close(request, request_of(message, TYPES, request.edge_times, 2.0, 10.0, rate))

    def test_simulated_robots_that_are_five_times_faster_need_a_fifth_of_the_time(self):
        request = PlanRequest((Task('r1', AGV, 8, ready=10.0),))
        assert request_message(request, 1, STAMP, GRAPH, 5.0).tasks[0].ready == 2.0

    def test_time_limits_are_the_nodes_where_none_is_named_and_never_longer_than_allowed(self):
        message = msg.PlanRequest(time_limit=0.0, improvement=60.0)
        request = request_of(message, TYPES, {}, 2.0, 10.0)
        assert (request.time_limit, request.improvement) == (2.0, 10.0)

    @pytest.mark.parametrize('message, words', [
        (msg.PlanRequest(time_limit=float('nan')), 'time_limit is nan'),
        (msg.PlanRequest(improvement=-1.0), 'improvement is -1.0'),
        (msg.PlanRequest(tasks=[msg.RobotTask(robot='r1', robot_type='truck')]),
         "Robot r1: there is no robot type 'truck'; the fleet file has agv."),
        (msg.PlanRequest(tasks=[msg.RobotTask(robot='\n', robot_type='agv')]), 'name'),
        (msg.PlanRequest(tasks=[msg.RobotTask(robot='r1', robot_type='agv', edge=1, fraction=1.5)]),
         'r1 stands at 1.5 of edge 1'),
        (msg.PlanRequest(obstacles=[msg.FleetObstacle(robot='r1', robot_type='truck')]), 'truck'),
        (msg.PlanRequest(laden_types=[laden('x', 'truck', 1.0, 1.0)]), "one of 'truck'"),
        (msg.PlanRequest(laden_types=[laden('agv', 'agv', 1.0, 1.0)]), 'name of its own'),
        (msg.PlanRequest(laden_types=[laden('x', 'agv', 0.3, 1.0)]), 'no smaller radius'),
        (msg.PlanRequest(laden_types=[laden('x', 'agv', 1.0, 1.1)]), 'no higher speed'),
        (msg.PlanRequest(laden_types=[laden('x', 'agv', 1.0, 0.0)]), 'a speed above 0'),
        (msg.PlanRequest(laden_types=[laden('x', 'agv', float('nan'), 1.0)]), 'radius'),
        (outlined([1.0, 2.0], [1.0]), 'An outline of robot r1 has 2 x and 1 y'),
        (outlined([], []), 'An outline of robot r1 has 0 x and 0 y'),
        (outlined([float('nan')], [0.0]), 'An outline of robot r1 has numbers that are not finite'),
        (outlined([0.0], [float('inf')]), 'An outline of robot r1 has numbers that are not finite'),
        (outlined([0.0], [0.0], float('nan')), 'An outline of robot r1 has the radius nan'),
        (outlined([0.0], [0.0], -0.1), 'An outline of robot r1 has the radius -0.1'),
    ])
    def test_that_make_no_sense_are_refused_in_a_sentence(self, message, words):
        with pytest.raises(CannotPlan, match='.') as refused:
            request_of(message, TYPES, {}, 2.0, 10.0)
        assert words in str(refused.value)


class TestAnswers:
    OUTCOME = PlanningOutcome(
        {'r2': (), 'r1': (PlannedDrive(3, -1.5, 0.25), PlannedDrive(-4, 0.25, 7.125))},
        (Constraint('r1', 0, 0.5, 'r2', 1),), {'r2': 'it is blocked by r1'}, 12.5, 8.0)
    REQUEST = request_message(
        PlanRequest((Task('r1', AGV, released=(3,), begun=0.5), Task('r2', AGV, 8))),
        7, STAMP, GRAPH)

    @pytest.mark.parametrize('rate', (1.0, 5.0))
    def test_arrive_as_they_were_sent(self, rate):
        answer = through_ros(answer_message(self.REQUEST, self.OUTCOME, 0.1, rate))
        assert answer.plan_id == 7
        assert answer.header.stamp == STAMP
        assert close(self.OUTCOME, outcome_of(answer, rate))

    def test_have_the_tasks_order_and_say_what_was_released(self):
        answer = answer_message(self.REQUEST, self.OUTCOME, 0.1)
        assert [plan.robot for plan in answer.plans] == ['r1', 'r2']
        assert answer.plans[0].released == 1
        assert answer.plans[0].drives.ends[1] == 7.125

    @pytest.mark.parametrize('drives', [([1, 2], [0.0], [1.0, 2.0]), ([1], [float('nan')], [1.0]),
                                        ([1], [0.0], [float('inf')]), ([], [], [1.0])])
    def test_of_drives_that_make_no_sense_are_no_plan(self, drives):
        wrong = msg.PlannedDrives(*drives)
        with pytest.raises(WrongAnswer, match="the plan of 'r1' has "):
            outcome_of(msg.PlanAnswer(plans=[msg.RobotPlan('r1', wrong, 0)]))
        task = msg.RobotTask(robot='r1', robot_type='agv', vertex=8, has_plan=True, kept=wrong)
        with pytest.raises(CannotPlan, match='The kept plan of robot r1 has '):
            request_of(msg.PlanRequest(tasks=[task]), TYPES, {}, 2.0, 10.0)

    @pytest.mark.parametrize('rules', [([0, 1], [0], [0.5], [1], [0]), ([0], [0], [0.5], [2], [0]),
                                       ([7], [0], [0.5], [1], [0])])
    def test_of_an_order_that_makes_no_sense_are_no_plan(self, rules):
        with pytest.raises(WrongAnswer, match='precedence'):
            outcome_of(msg.PlanAnswer(precedence=msg.Precedence(['r1', 'r2'], *rules)))

    def test_without_a_plan_say_why(self):
        answer = through_ros(no_plan_message(self.REQUEST, msg.PlanAnswer.REFUSED, 'no'))
        assert (answer.plan_id, answer.result, answer.reason) == (7, answer.REFUSED, 'no')
