"""The checker counts a vehicle's messages, and allows for losses when a broker was killed."""
from __future__ import annotations

from typing import Sequence

import pytest
from vda_messages import payload

from vda5050_bench.checker import VehicleChecker

TOPIC = 'visualization'


@pytest.fixture
def checker() -> VehicleChecker:
    return VehicleChecker('OMRON', 'lab')


def feed(checker: VehicleChecker, header_ids: Sequence[int]) -> None:
    for header_id in header_ids:
        checker.feed(TOPIC, payload({}, header_id))


@pytest.mark.parametrize('ids, is_right', [
    ((0, 1, 2), True), ((5, 6, 7), True), ((0, 2), False), ((0, 1, 1), False), ((3, 2), False)])
def test_header_ids_count_by_one(checker, ids, is_right):
    feed(checker, ids)
    assert (checker.violations == []) == is_right


@pytest.mark.parametrize('later, is_right', [
    ((3, 4), True), ((2, 3), True), ((2, 5, 6), True), ((5, 7), False), ((1,), False)])
def test_after_the_death_of_a_broker_they_may_jump_on_once(checker, later, is_right):
    feed(checker, (0, 1))
    checker.broker_lost()
    feed(checker, later)
    assert (checker.violations == []) == is_right


def test_of_a_restarted_program_they_may_begin_anew(checker):
    feed(checker, (7, 8))
    checker.restarted()
    feed(checker, (0, 1))
    assert checker.violations == []
