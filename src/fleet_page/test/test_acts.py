"""The page accepts exactly the acts in the table from a client."""
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_page.core.acts import RULES, Act, ActKind, WrongAct, act_of
from fleet_page.core.roles import UserRole

JSON = st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
                    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner))


def test_a_mission_has_destinations_stays_and_a_robot():
    assert act_of({'act': 'send', 'destinations': [3, 4], 'stays': [0, -1], 'robot': 'a',
                   'robot_type': '', 'priority': 2}) == Act(
        ActKind.SEND, robot='a', priority=2, destinations=(3, 4), stays=(0.0, -1.0))


def test_an_answer_keeps_all_digits_of_the_key():
    assert act_of({'act': 'answer', 'mission': 7, 'answer': 'skip', 'step': str(2 ** 64 - 1)}) == (
        Act(ActKind.ANSWER, mission=7, answer='skip', step=2 ** 64 - 1))


@pytest.mark.parametrize('request_, words', [
    ([], 'JSON object'), ({}, 'no such act'), ({'act': []}, 'no such act'),
    ({'act': 'stop', 'robot': 'a'}, 'takes nothing'),
    ({'act': 'send'}, 'destinations is missing'),
    ({'act': 'send', 'destinations': []}, 'list of 1 to 100 ids'),
    ({'act': 'send', 'destinations': [True]}, 'whole number'),
    ({'act': 'send', 'destinations': ['a\nb']}, 'printable'),
    ({'act': 'modify', 'mission': 7, 'priority': 1, 'destinations': ['press']}, 'whole number'),
    ({'act': 'send', 'destinations': [2 ** 31]}, 'whole number'),
    ({'act': 'send', 'destinations': [-1]}, 'positive'),
    ({'act': 'send', 'destinations': [1], 'stays': [math.nan]}, 'seconds'),
    ({'act': 'send', 'destinations': [1], 'stays': [1, 2]}, 'as many'),
    ({'act': 'send', 'destinations': [1], 'stays': [10 ** 400]}, 'seconds up to 1000000'),
    ({'act': 'send', 'destinations': [1], 'stays': [-10 ** 400]}, 'or negative'),
    ({'act': 'out', 'robot': 'a\n'}, 'printable'), ({'act': 'out', 'robot': ' '}, 'printable'),
    ({'act': 'cancel', 'mission': '1'}, 'whole number'),
    ({'act': 'answer', 'mission': 1, 'answer': 'retry'}, 'step is missing'),
    ({'act': 'answer', 'mission': 1, 'answer': 'RETRY', 'step': '1'}, 'retry, skip, fail, done'),
    ({'act': 'answer', 'mission': 1, 'answer': [], 'step': '1'}, 'retry, skip, fail, done'),
    ({'act': 'answer', 'mission': 1, 'answer': 'done', 'step': 1}, 'as text'),
    ({'act': 'answer', 'mission': 1, 'answer': 'done', 'step': '٣'}, 'as text'),
    ({'act': 'answer', 'mission': 1, 'answer': 'done', 'step': str(2 ** 64)}, 'as text'),
    ({'act': 'run', 'name': 'a'}, 'arguments is missing'),
    ({'act': 'run', 'name': 'a', 'arguments': [['b', 'c']]}, 'object of at most 50 texts'),
    ({'act': 'run', 'name': 'a', 'arguments': {'b': ''}}, 'printable'),
    ({'act': 'run', 'name': 'a', 'arguments': {'b': 3}}, 'printable'),
    ({'act': 'close', 'edges': [1] * 1001}, 'list of 1 to 1000')])
def test_a_wrong_request_is_refused_in_words(request_, words):
    with pytest.raises(WrongAct, match=words):
        act_of(request_)


@given(JSON, st.sampled_from([kind.value for kind in ActKind]), JSON)
def test_anything_else_is_refused_and_never_fails(content, kind, value):
    for request in (content, {'act': kind, 'destinations': value}, {'act': kind, 'robot': value},
                    {'act': kind, 'mission': value, 'stays': value},
                    {'act': kind, 'name': 'a', 'arguments': value}):
        try:
            act = act_of(request)
        except WrongAct:
            continue
        assert isinstance(act, Act)


def test_every_act_has_a_rule_and_no_act_is_for_those_who_only_see():
    assert set(RULES) == set(ActKind)
    assert all(rule.role > UserRole.SEE for rule in RULES.values())
