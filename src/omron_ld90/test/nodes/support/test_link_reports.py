"""Changes of a link on `link_state`, in /diagnostics, and in the log."""
from __future__ import annotations

from typing import Any, List

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import ConfigurationError
from omron_arcl import Link, LinkPhase
from omron_ld90.nodes.support import link_reports
from omron_ld90.nodes.support.link_reports import LinkReporter, robot_host, words_of
from omron_ld90_msgs.msg import LinkState

ROBOT = '10.0.0.5:7171'


class Topic(list):
    """The published messages."""

    publish = list.append


@pytest.fixture(autouse=True)
def topic(monkeypatch) -> Topic:
    published = Topic()
    monkeypatch.setattr(rospy, 'Publisher', lambda *_, **__: published)
    monkeypatch.setattr(rospy, 'on_shutdown', lambda _: None)
    monkeypatch.setattr(link_reports, 'Periodic', lambda *_: None)
    monkeypatch.setattr(rospy.Time, 'now', staticmethod(lambda: rospy.Time(100)))
    monkeypatch.setattr(link_reports, 'PATIENCE', 0.0)
    monkeypatch.setattr(link_reports, 'SETTLED', 0.0)
    return published


@pytest.fixture
def logged(monkeypatch) -> List[str]:
    said: List[str] = []
    monkeypatch.setattr(rospy, 'loginfo', lambda text, *arguments: said.append(text % arguments))
    monkeypatch.setattr(link_reports, 'warn', lambda _, text: said.append(text))
    return said


def diagnosis(reporter: LinkReporter) -> DiagnosticStatusWrapper:
    return reporter.diagnose(DiagnosticStatusWrapper())


@pytest.mark.parametrize(('phase', 'state'), [
    (LinkPhase.DISCONNECTED, LinkState.DISCONNECTED),
    (LinkPhase.CONNECTING, LinkState.CONNECTING),
    (LinkPhase.LOGGING_IN, LinkState.LOGGING_IN),
    (LinkPhase.CONNECTED, LinkState.CONNECTED),
    (LinkPhase.WRONG_PASSWORD, LinkState.WRONG_PASSWORD),
])
def test_every_phase_is_published_as_its_state(topic, logged, phase, state):
    LinkReporter(LinkState.COMMANDS).report(Link(phase, ROBOT, 'why'))
    message = topic[-1]
    assert (message.link, message.state) == (LinkState.COMMANDS, state)
    assert (message.address, message.reason) == (ROBOT, 'why')
    assert words_of(state) == phase.value


def test_the_last_word_is_repeated_so_that_others_know_that_the_node_is_alive(topic, logged):
    reporter = LinkReporter(LinkState.OUTGOING)
    reporter._repeat()
    assert topic == []
    reporter.report(Link(LinkPhase.CONNECTED, ROBOT))
    reporter._repeat()
    assert topic == [topic[0]] * 2


def test_a_link_that_stays_as_it_is_is_logged_once(logged):
    reporter = LinkReporter(LinkState.COMMANDS)
    for _ in range(3):
        for phase, reason in ((LinkPhase.CONNECTING, 'connecting'),
                              (LinkPhase.DISCONNECTED, 'connection refused')):
            reporter.report(Link(phase, ROBOT, reason))
            reporter._repeat()
    assert logged == [f'Link "commands" to {ROBOT} is down: connection refused.']
    reporter.report(Link(LinkPhase.CONNECTED, ROBOT))
    assert logged[1:] == [f'Link "commands" to {ROBOT} is up.']


REFUSED = Link(LinkPhase.DISCONNECTED, ROBOT, 'connection refused')


def test_while_the_programs_of_a_start_begin_a_robot_that_was_not_reached_is_no_warning(
        logged, monkeypatch):
    monkeypatch.setattr(link_reports, 'PATIENCE', 1000.0)
    reporter = LinkReporter(LinkState.COMMANDS)
    for link in (REFUSED, Link(LinkPhase.CONNECTING, ROBOT, 'connecting')):
        reporter.report(link)
        reporter._repeat()
    assert logged == [] and diagnosis(reporter).level == DiagnosticStatus.WARN
    monkeypatch.setattr(link_reports.time, 'monotonic', lambda: reporter._began + 1001.0)
    for _ in range(2):
        reporter._repeat()
    assert logged == [f'Link "commands" to {ROBOT} is down: connection refused.']


def test_what_a_start_does_not_mend_is_told_at_once(logged, monkeypatch):
    monkeypatch.setattr(link_reports, 'PATIENCE', 1000.0)
    reporter = LinkReporter(LinkState.COMMANDS)
    reporter.report(Link(LinkPhase.WRONG_PASSWORD, ROBOT, 'wrong password'))
    reporter.report(Link(LinkPhase.CONNECTED, ROBOT))
    reporter.report(REFUSED)
    reporter._repeat()
    assert [line.split(': ')[-1] for line in logged] == [
        'wrong password.', f'Link "commands" to {ROBOT} is up.', 'connection refused.']


def test_a_link_that_was_lost_for_a_moment_is_told_before_it_is_up_again(logged, monkeypatch):
    monkeypatch.setattr(link_reports, 'SETTLED', 1000.0)
    reporter = LinkReporter(LinkState.COMMANDS)
    for link in (Link(LinkPhase.CONNECTED, ROBOT), REFUSED, Link(LinkPhase.CONNECTED, ROBOT)):
        reporter.report(link)
        reporter._repeat()
    assert [line.split(' is ')[-1] for line in logged] == [
        'up.', 'down: connection refused.', 'up.']


def test_a_link_that_the_ending_node_closes_is_no_news(monkeypatch):
    """A user who presses Ctrl-C gets no message about a link."""
    said: List[str] = []
    warned: List[str] = []
    monkeypatch.setattr(rospy, 'loginfo', lambda text, *arguments: said.append(text % arguments))
    monkeypatch.setattr(link_reports, 'warn', lambda _, text: warned.append(text))
    reporter = LinkReporter(LinkState.OUTGOING)
    reporter.report(Link(LinkPhase.DISCONNECTED, ROBOT, 'connection reset'))
    reporter._repeat()
    reporter.report(Link(LinkPhase.CONNECTED, ROBOT))
    reporter.report(Link(LinkPhase.DISCONNECTED, ROBOT, 'the simulator has ended'))
    monkeypatch.setattr(rospy.core, '_in_shutdown', True)  # is_shutdown() becomes True later
    reporter._repeat()
    reporter.report(Link(LinkPhase.DISCONNECTED, ROBOT, 'closed by us'))
    reporter._repeat()
    assert warned == [f'Link "outgoing" to {ROBOT} is down: connection reset.']
    assert said == [f'Link "outgoing" to {ROBOT} is up.']


def test_the_diagnosis_is_an_error_unless_it_is_connected(logged):
    reporter = LinkReporter(LinkState.COMMANDS)
    assert diagnosis(reporter).level == DiagnosticStatus.WARN
    reporter.report(Link(LinkPhase.DISCONNECTED, ROBOT, 'connection refused'))
    assert diagnosis(reporter).level == DiagnosticStatus.ERROR
    assert 'connection refused' in diagnosis(reporter).message
    reporter.report(Link(LinkPhase.CONNECTED, ROBOT))
    reporter.line()
    values = {value.key: value.value for value in diagnosis(reporter).values}
    assert diagnosis(reporter).level == DiagnosticStatus.OK
    assert values['connections made'] == '1'
    assert float(values['age of last line [s]']) < 10.0


@pytest.mark.parametrize(('host', 'possible'), [
    ('10.0.0.5', True), ('robot.factory', True), ('10.0..5', False), ('robot one', False)])
def test_what_can_be_no_robot_is_a_wrong_parameter(monkeypatch, host, possible):
    parameters: Any = {'~robot_ip': host}
    monkeypatch.setattr(rospy, 'get_param', lambda name, _: parameters[name])
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name)
    if possible:
        assert robot_host() == host
        return
    with pytest.raises(ConfigurationError, match='neither an address nor a name'):
        robot_host()
