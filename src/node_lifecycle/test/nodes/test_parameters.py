"""One sentence refuses a parameter that is missing, has another type, or is out of range."""
from __future__ import annotations

import math

import pytest
import rospy

from node_lifecycle import ConfigurationError, choice, number, parameter
from node_lifecycle.parameters import REQUIRED


@pytest.fixture
def given(monkeypatch):
    """Returns the parameters that the server has; a test adds some."""
    values = {}
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: values.get(name, default))
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', '/node/'))
    return values


@pytest.mark.parametrize(('value', 'kind', 'read'), [
    ('a', str, 'a'), (1234, str, '1234'), (1.5, str, '1.5'), (2, float, 2.0), (2, int, 2),
    (True, bool, True), ([1], list, [1])])
def test_a_parameter_of_the_right_type_is_read(given, value, kind, read):
    given['~x'] = value
    assert parameter('~x', kind=kind) == read
    assert type(parameter('~x', kind=kind)) is kind


@pytest.mark.parametrize(('value', 'kind'), [
    ('a', int), (1.5, int), (True, int), (True, float), (True, str), ('2', float), (1, bool),
    (math.nan, float), (math.inf, float), ([], str)])
def test_one_of_another_type_is_refused(given, value, kind):
    given['~x'] = value
    with pytest.raises(ConfigurationError, match='^Parameter /node/x is .*, but must be .*[.]$'):
        parameter('~x', kind=kind)


@pytest.mark.parametrize('value', [REQUIRED, ''])
def test_a_required_one_must_be_there_and_not_empty(given, value):
    given['~x'] = value
    with pytest.raises(ConfigurationError, match='^Parameter /node/x is missing: set it'):
        parameter('~x')


def test_an_empty_text_is_taken_where_there_is_a_default(given):
    given['~x'] = ''
    assert parameter('~x', 'default') == ''
    assert parameter('~y', 'default') == 'default'


def test_a_number_must_lie_within_its_limits(given):
    given['~x'] = 5
    assert number('~x', 1.0, 0.0, 5.0) == 5.0
    with pytest.raises(ConfigurationError, match='is 5.0, but must lie in 0.0..4.0'):
        number('~x', 1.0, 0.0, 4.0)


def test_a_choice_must_be_one_of_those_there_are(given):
    assert choice('~x', 'a', ('a', 'b')) == 'a'
    given['~x'] = 'c'
    with pytest.raises(ConfigurationError, match="is 'c', but must be one of a, b"):
        choice('~x', 'a', ('a', 'b'))
