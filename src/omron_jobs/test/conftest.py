"""Common fixtures of the job server's tests."""
from __future__ import annotations

import time
from typing import Iterator

import pytest
from job_line import Line


@pytest.fixture
def line(monkeypatch: pytest.MonkeyPatch) -> Iterator[Line]:
    monkeypatch.setenv('TZ', 'UTC')
    time.tzset()
    yield Line()
    monkeypatch.undo()
    time.tzset()
