"""Goals of ROS actions: no goal is lost on the way to a server, and each goal ends once."""
from __future__ import annotations

from typing import Any, Callable, List, Tuple

import pytest

pytest.importorskip('actionlib')

from actionlib import CommState, GoalStatus  # noqa: E402

from node_lifecycle.lost_goals import STATUSES_WAITED  # noqa: E402
from vda5050_vehicle.nodes.action_goals import PATIENCE, ActionGoals  # noqa: E402


class Connections:
    """Replaces a publisher or a subscriber of actionlib; `count` is its number of connections."""

    def __init__(self) -> None:
        self.count = 0

    def get_num_connections(self) -> int:
        return self.count


class Handle:
    """A goal that was sent."""

    def __init__(self, client: Client, goal: str, on_transition: Callable[[Any], None]) -> None:
        self._client, self._goal, self._on_transition = client, goal, on_transition
        self._state, self._status, self._text = CommState.ACTIVE, GoalStatus.ACTIVE, ''

    def cancel(self) -> None:
        self._client.heard.append(f'cancel {self._goal}')

    def ends(self, status: int, text: str) -> None:
        self._state, self._status, self._text = CommState.DONE, status, text
        self._on_transition(self)

    def comes_to(self, state: int) -> None:
        """Sets the state that actionlib derives from the server's statuses."""
        self._state = state

    def get_comm_state(self) -> int:
        return self._state

    def get_terminal_state(self) -> int:
        return self._status

    def get_goal_status_text(self) -> str:
        return self._text


class Client:
    """Replaces actionlib.ActionClient; `heard` lists what a connected server receives."""

    ns = 'lift'

    def __init__(self) -> None:
        self.pub_goal, self.pub_cancel = Connections(), Connections()
        self.status_sub, self.feedback_sub, self.result_sub = (Connections() for _ in range(3))
        self.last_status_msg = object()
        self.heard: List[str] = []
        self.handles: List[Handle] = []

    def connect(self, count: int = 1) -> None:
        for end in (self.pub_goal, self.pub_cancel, self.status_sub, self.feedback_sub,
                    self.result_sub):
            end.count = count

    def send_goal(self, goal: str, on_transition: Callable[[Any], None]) -> Handle:
        if self.pub_goal.count:
            self.heard.append(goal)
        self.handles.append(Handle(self, goal, on_transition))
        return self.handles[-1]

    def cancel_all_goals(self) -> None:
        if self.pub_cancel.count:
            self.heard.append('cancel all')


class Bench:
    """Goals of one client, with a clock of its own."""

    def __init__(self) -> None:
        self.now = 0.0
        self.client = Client()
        self.ends: List[Tuple[str, bool, str]] = []
        self.goals = ActionGoals(lambda *end: self.ends.append(end), lambda: self.now)

    def statuses(self, count: int) -> None:
        """Lets the client receive this number of statuses, with a check of the goals after each."""
        for _ in range(count):
            self.client.last_status_msg = object()
            self.goals.check()

    def send(self, name: str = 'up') -> None:
        self.goals.send(name, self.client, f'goal {name}')


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_goal_is_sent_at_once_where_the_server_is_there(bench):
    bench.client.connect()
    bench.send()
    assert (bench.client.heard, bench.ends) == (['goal up'], [])


def test_a_goal_waits_for_a_server_that_starts_later_and_is_sent_once(bench):
    bench.send()
    bench.goals.check()
    assert (bench.client.heard, bench.ends) == ([], [])
    bench.client.connect()
    bench.goals.check()
    bench.goals.check()
    assert (bench.client.heard, bench.ends) == (['goal up'], [])


@pytest.mark.parametrize('missing', ['pub_goal', 'pub_cancel', 'feedback_sub', 'result_sub'])
def test_a_goal_is_not_sent_over_half_a_connection(bench, missing):
    bench.client.connect()
    getattr(bench.client, missing).count = 0
    bench.send()
    assert bench.client.heard == []


def test_a_goal_whose_server_does_not_come_fails_and_is_never_sent(bench):
    bench.send()
    bench.now = PATIENCE
    bench.goals.check()
    assert bench.ends == [('up', False, 'there is no action server lift')]
    bench.client.connect()
    bench.goals.check()
    assert bench.client.heard == [] and len(bench.ends) == 1


def test_a_goal_that_is_cancelled_while_it_waits_is_never_sent(bench):
    bench.send()
    bench.goals.cancel('up')
    bench.client.connect()
    bench.goals.check()
    assert bench.client.heard == []
    assert bench.ends == [('up', False, 'the goal was cancelled before its server was connected')]


def test_a_goal_that_was_sent_is_cancelled_and_ends_when_the_server_says_so(bench):
    bench.client.connect()
    bench.send()
    bench.goals.cancel('up')
    assert (bench.client.heard, bench.ends) == (['goal up', 'cancel goal up'], [])
    bench.client.handles[0].ends(GoalStatus.PREEMPTED, 'as\nwanted')
    assert bench.ends == [('up', False, 'as wanted')]


def test_a_goal_that_succeeds_ends_once(bench):
    bench.client.connect()
    bench.send()
    bench.client.handles[0].ends(GoalStatus.SUCCEEDED, '')
    bench.client.connect(0)
    bench.goals.check()
    assert bench.ends == [('up', True, 'SUCCEEDED')]


def test_a_goal_ends_when_its_server_is_gone(bench):
    bench.client.connect()
    bench.send()
    bench.client.connect(0)
    bench.goals.check()
    assert bench.ends == [('up', False, 'the action server lift has disappeared')]


@pytest.mark.parametrize('state, told', [
    (CommState.WAITING_FOR_GOAL_ACK, 'the action server lift did not receive the goal'),
    (CommState.WAITING_FOR_RESULT, 'the result of the action server lift was lost')])
def test_what_got_lost_is_not_waited_for_for_ever(bench, state, told):
    bench.client.connect()
    bench.send()
    bench.statuses(100)  # the server may take its time
    bench.client.handles[0].comes_to(state)
    bench.statuses(STATUSES_WAITED + 1)
    assert bench.ends == [], 'the goal may still be on its way'
    bench.statuses(1)
    assert bench.ends == [('up', False, told)]


def test_cancelling_all_is_owed_until_the_server_can_hear_it(bench):
    """An adapter that was killed during a drive cancels the goals at its next start, before it has
    connections.
    """
    bench.goals.cancel_all(bench.client)
    assert bench.client.heard == []
    bench.client.pub_cancel.count = 1  # the cancellation does not wait for other connections
    bench.goals.check()
    bench.goals.check()
    assert bench.client.heard == ['cancel all']


def test_cancelling_all_ends_what_waits_and_leaves_what_comes_after_it(bench):
    bench.send('before')
    bench.goals.cancel_all(bench.client)
    bench.send('after')
    assert [name for name, *_ in bench.ends] == ['before']
    bench.client.connect()
    bench.goals.check()
    assert bench.client.heard == ['cancel all']  # the goal must not overtake the cancellation
    bench.goals.check()
    assert bench.client.heard == ['cancel all', 'goal after']
