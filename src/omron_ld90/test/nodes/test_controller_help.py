"""Commands that the robot's help list lacks are named in a warning, and sent."""
from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_arcl import HelpList, parse_command
from omron_ld90.nodes import controller_help
from omron_ld90.nodes.controller_help import HelpReport


@pytest.fixture(autouse=True)
def warnings(monkeypatch) -> list:
    said = []
    monkeypatch.setattr(controller_help.rospy, 'logwarn', lambda *words: said.append(words))
    return said


def report(*listed: str, sent: tuple = ()) -> DiagnosticStatusWrapper:
    help_report = HelpReport()
    help_report.listed(HelpList(dict.fromkeys(listed, '')))
    for text in sent:
        help_report.sent(parse_command(text))
    return help_report.diagnose(DiagnosticStatusWrapper())


def test_what_the_robot_lists_is_well():
    assert report('goto', 'stop', sent=('goto 1', 'STOP')).level == DiagnosticStatus.OK


def test_what_it_does_not_list_is_a_warning_said_once(warnings):
    status = report('stop', sent=('goto 1', 'goto 2', 'patrol r'))
    assert status.level == DiagnosticStatus.WARN
    assert status.message.endswith('goto, patrol')
    assert len(warnings) == 2


def test_a_robot_without_a_help_list_is_no_warning():
    assert report(sent=('goto 1',)).level == DiagnosticStatus.OK
