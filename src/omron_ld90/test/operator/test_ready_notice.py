"""A start ends with one line: the robot is ready, and what a person can do."""
from __future__ import annotations

from omron_ld90.operator.goal_clicks import Target, TargetKind
from omron_ld90.operator.ready_notice import Advice, ReadyNotice

GOAL = Target(TargetKind.GOAL, 'Packing 2', 1.0, 2.0)
DOCK = Target(TargetKind.DOCK, '16', 0.0, 0.0)
NAMELESS = Target(TargetKind.GOAL, 'a "name"', 1.0, 2.0)


def test_it_is_said_once_when_a_map_is_displayed_and_the_robot_is_reached() -> None:
    notice = ReadyNotice('omron_ld90')
    assert not notice.words(None, True) and not notice.words([], True)
    assert not notice.words([GOAL], False)
    assert notice.words([GOAL], True) == (
        'Ready: omron_ld90. Click a goal in RViz, or publish a command: rostopic pub -1 '
        '/omron_ld90/send_command std_msgs/String \'goto "Packing 2"\'')
    assert not notice.words([GOAL], True)


def test_the_example_is_a_command_that_there_is() -> None:
    assert ReadyNotice('r').words([NAMELESS, GOAL], True).endswith('\'goto "Packing 2"\'')
    assert ReadyNotice('r').words([DOCK, GOAL], True).endswith('\'goto "Packing 2"\'')
    assert ReadyNotice('r').words([NAMELESS], True).endswith('String stop')


def test_a_robot_of_a_fleet_manager_gets_missions_and_no_commands_past_it() -> None:
    vertex = Target(TargetKind.GOAL, '18', 1.0, 2.0)
    words = ReadyNotice('r', Advice.MISSION).words([DOCK, GOAL, vertex], True)
    assert words == ('Ready: r. Click a goal in RViz, or send a mission to a vertex: rosrun '
                     'graph_fleet_manager mission 18 --robot r')
    assert ReadyNotice('r', Advice.MISSION).words([GOAL], True).endswith('mission VERTEX --robot r')


def test_it_says_nothing_if_another_node_says_what_is_ready() -> None:
    assert ReadyNotice('r', Advice.NOTHING).words([GOAL], True) == ''
