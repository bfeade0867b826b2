"""The robot's entry in /diagnostics, from the lines it sends."""
from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from omron_arcl import parse_line
from omron_ld90.nodes.support.robot_health import RobotHealth


def after(*lines: str) -> DiagnosticStatusWrapper:
    health = RobotHealth()
    for line in lines:
        health.observe(parse_line(line))
    return health.diagnose(DiagnosticStatusWrapper())


@pytest.mark.parametrize(('lines', 'level', 'message'), [
    (('Status: Going to 12', 'StateOfCharge: 79.4', 'LocalizationScore: 0.8'),
     DiagnosticStatus.OK, 'Going to 12'),
    (('Status: Stopped', 'EStop pressed'), DiagnosticStatus.ERROR, 'emergency stop'),
    (('Status: EStop relieved but motors still disabled',), DiagnosticStatus.ERROR,
     'emergency stop'),
    (('Status: Stopped', 'Motors disabled'), DiagnosticStatus.WARN, 'motors disabled'),
    (('Status: Robot lost',), DiagnosticStatus.ERROR, 'does not know where'),
    (('Status: Stopped', 'StateOfCharge: 20'), DiagnosticStatus.WARN, 'battery low'),
    (('Status: Stopped', 'StateOfCharge: 5'), DiagnosticStatus.ERROR, 'battery empty'),
    (('Status: Stopped', 'LocalizationScore: 0.1'), DiagnosticStatus.WARN, 'poorly localized'),
    (('Status: Stopped', 'Fault: Fault_Driving f "s" "l" true false true'),
     DiagnosticStatus.ERROR, 'faults: f'),
])
def test_the_worst_matter_sets_the_level(lines, level, message):
    status = after(*lines)
    assert status.level == level
    assert message in status.message


def test_what_is_over_is_no_longer_reported():
    status = after('EStop pressed', 'Motors enabled', 'Fault: k f "s" "l" true false true',
                   'FaultCleared: k f "s" "l" true false true', 'Status: Stopped')
    assert status.level == DiagnosticStatus.OK


def test_a_silent_robot_is_stale_not_well():
    assert after('hello').level == DiagnosticStatus.STALE


def test_after_the_link_broke_nothing_is_known():
    health = RobotHealth()
    health.observe(parse_line('EStop pressed'))
    health.forget()
    assert health.diagnose(DiagnosticStatusWrapper()).level == DiagnosticStatus.STALE
