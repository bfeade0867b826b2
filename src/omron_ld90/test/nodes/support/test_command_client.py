"""A command ends with the result of its goal, or as LOST if the goal is lost."""
from __future__ import annotations

import threading
from types import SimpleNamespace

import pytest
from actionlib import CommState, GoalStatus

from node_lifecycle.lost_goals import STATUSES_WAITED
from omron_ld90.nodes.support import command_client
from omron_ld90.nodes.support.command_client import CommandClient, result_of
from omron_ld90_msgs.msg import ExecuteCommandResult


class DoneGoal:
    """The handle of a goal that is done."""

    def __init__(self, status: int, result=None, text: str = '') -> None:
        self.get_terminal_state = lambda: status
        self.get_result = lambda: result
        self.get_goal_status_text = lambda: text


def test_the_result_is_the_controllers():
    result = ExecuteCommandResult(outcome=ExecuteCommandResult.FAILED, message='No such goal')
    assert result_of(DoneGoal(GoalStatus.ABORTED, result)) is result
    done = ExecuteCommandResult(outcome=ExecuteCommandResult.SUCCEEDED, message='Arrived at 12')
    assert result_of(DoneGoal(GoalStatus.SUCCEEDED, done)) is done


def test_a_goal_that_the_server_forgot_is_lost():
    assert result_of(DoneGoal(GoalStatus.LOST)).outcome == ExecuteCommandResult.LOST


@pytest.mark.parametrize('status', [GoalStatus.RECALLED, GoalStatus.PREEMPTED])
def test_the_empty_result_of_a_goal_that_actionlib_refused_is_no_success(status):
    result = result_of(DoneGoal(status, ExecuteCommandResult(), 'canceled by its timestamp'))
    assert result.outcome == ExecuteCommandResult.CANCELLED
    assert result.message == 'canceled by its timestamp'


class Server:
    """Replaces the controller, as actionlib's client sees it."""

    def __init__(self) -> None:
        ends = SimpleNamespace(get_num_connections=lambda: 1)
        self.pub_goal = self.status_sub = self.result_sub = ends
        self.last_status_msg = object()
        self.state = CommState.WAITING_FOR_GOAL_ACK

    def send_goal(self, goal, **callbacks):
        self.goal = goal
        return SimpleNamespace(get_comm_state=lambda: self.state)


@pytest.fixture
def server(monkeypatch) -> Server:
    server = Server()
    monkeypatch.setattr(command_client.actionlib, 'ActionClient', lambda name, kind: server)
    return server


def test_the_epoch_that_is_known_goes_with_a_command(server):
    commands = CommandClient(lambda number, result: None)
    commands.give(1, 'goto 12', 77)
    assert (server.goal.command, server.goal.known_epoch) == ('goto 12', 77)
    commands.close()


@pytest.mark.parametrize('state, lost', [
    (CommState.WAITING_FOR_GOAL_ACK, True), (CommState.WAITING_FOR_RESULT, True),
    (CommState.ACTIVE, False)])
def test_what_got_lost_on_its_way_is_not_waited_for_for_ever(server, state, lost):
    results, heard = [], threading.Event()
    commands = CommandClient(lambda number, result: (results.append(result), heard.set()))
    commands.give(1, 'goto 12')
    server.state = CommState.ACTIVE
    for _ in range(3 * STATUSES_WAITED):
        server.last_status_msg = object()
        commands.check()
    server.state = state
    for _ in range(STATUSES_WAITED + 1):
        server.last_status_msg = object()
        commands.check()
    assert not results, 'the goal may still be on its way'
    server.last_status_msg = object()
    commands.check()
    assert heard.wait(5.0 if lost else 0.1) is lost
    assert [result.outcome for result in results] == [ExecuteCommandResult.LOST] * lost
    commands.close()
