"""A task of the diagnostics that fails shows it, and ends no others."""
from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import diagnostics


@pytest.fixture(autouse=True)
def silent(monkeypatch) -> None:
    monkeypatch.setattr(diagnostics, 'warn', lambda kind, message: None)


def test_a_task_that_fails_says_so():
    def fails(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        raise KeyError('x')

    status = diagnostics.guarded(fails)(DiagnosticStatusWrapper())
    assert status.level == DiagnosticStatus.ERROR
    assert "KeyError('x')" in status.message


def test_text_that_is_no_unicode_can_be_published():
    def task(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        status.summary(DiagnosticStatus.OK, 'K\udcfcche')
        status.add('goals', '\udcfc')
        return status

    status = diagnostics.guarded(task)(DiagnosticStatusWrapper())
    assert status.message == r'K\udcfcche'
    assert status.values[0].value == r'\udcfc'
