"""A diagnostics task that fails reports the failure, and stops no other task."""
from __future__ import annotations

from typing import List

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import diagnostics


@pytest.fixture(autouse=True)
def told(monkeypatch) -> List[str]:
    """Returns the messages in the log."""
    messages: List[str] = []
    monkeypatch.setattr(diagnostics, 'warn', lambda kind, message: messages.append(message))
    return messages


def test_a_task_that_fails_says_so():
    def fails(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        raise KeyError('x')

    status = diagnostics.guarded(fails)(DiagnosticStatusWrapper())
    assert status.level == DiagnosticStatus.ERROR
    assert "KeyError('x')" in status.message


def test_what_fails_for_long_is_told_when_it_begins_and_when_it_ends(told):
    errors = [KeyError('x')] * 5 + [None] * 2

    def task(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        error = errors.pop(0)
        if error is not None:
            raise error
        return status

    ask = diagnostics.guarded(task)
    for _ in range(len(errors)):
        ask(DiagnosticStatusWrapper())
    assert told == ["A part of the diagnostics failed: KeyError('x')",
                    'The part of the diagnostics that had failed works again.']


def test_text_that_is_no_unicode_can_be_published():
    def task(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        status.summary(DiagnosticStatus.OK, 'K\udcfcche')
        status.add('goals', '\udcfc')
        return status

    status = diagnostics.guarded(task)(DiagnosticStatusWrapper())
    assert status.message == r'K\udcfcche'
    assert status.values[0].value == r'\udcfc'
