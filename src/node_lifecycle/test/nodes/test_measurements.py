"""A reader ignores a measurement out of range, with a warning, and never replaces it by a limit."""
from __future__ import annotations

import math

import pytest

from node_lifecycle import measurements
from node_lifecycle.measurements import measured


@pytest.fixture
def said(monkeypatch) -> list:
    lines: list = []
    monkeypatch.setattr(measurements, 'warn', lambda kind, line: lines.append(line))
    return lines


@pytest.mark.parametrize('value', [0.0, 0.5, 1.0])
def test_a_value_within_its_range_is_taken(said, value):
    assert measured(value, 0.0, 1.0, 'The charge') == value
    assert not said


@pytest.mark.parametrize('value', [23.0, 100.0, 1.5, -0.01, -1.0, math.inf, -math.inf])
def test_a_value_out_of_range_is_ignored_and_named(said, value):
    assert measured(value, 0.0, 1.0, 'The charge of robot a') is None
    assert said == [f'The charge of robot a is ignored: it is {value:g}, but must be from 0 to 1.']


def test_what_is_not_measured_is_ignored_without_a_word(said):
    assert measured(math.nan, 0.0, 1.0, 'The charge') is None
    assert not said
