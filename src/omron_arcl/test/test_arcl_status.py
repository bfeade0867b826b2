"""A status is assembled from its lines, in any order and number."""
from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from arcl_builders import STATUS

from omron_arcl import StatusAssembler, parse_line
from omron_arcl.replies import (
    BatteryVoltage,
    LocalizationScore,
    Location,
    OneLineStatus,
    StateOfCharge,
    Temperature,
)

REPLIES = [parse_line(line.decode()) for line in STATUS]
WHOLE = OneLineStatus('Going to 12', 'Going to 12', StateOfCharge(79.4), None,
                      Location(3120, -540, -87), LocalizationScore(0.870543), Temperature(36))


def test_the_first_status_is_whole_when_the_second_begins_and_that_with_its_last_line():
    assembler = StatusAssembler()
    assert [assembler.add(reply) for reply in REPLIES * 2] == (
        [None] * 6 + [WHOLE] + [None] * 4 + [WHOLE])


def test_a_score_that_comes_after_the_temperature_is_part_of_the_first_status():
    order = [reply for reply in REPLIES if not isinstance(reply, LocalizationScore)]
    order.append(WHOLE.localization_score)
    assembler = StatusAssembler()
    statuses = [assembler.add(reply) for _ in range(2) for reply in order]
    assert [status for status in statuses if status] == [WHOLE, WHOLE]


def test_lines_that_are_dropped_are_in_no_status():
    assembler = StatusAssembler()
    for reply in REPLIES * 2 + [Location(7, 7, 7)]:
        assembler.add(reply)
    assembler.drop()
    assert [status for status in map(assembler.add, REPLIES) if status] == [WHOLE]


@pytest.mark.parametrize('order', itertools.islice(itertools.permutations(REPLIES), 0, 720, 7))
def test_in_any_order_of_fields_each_location_comes_out_once(order):
    assembler = StatusAssembler()
    statuses = [assembler.add(Location(cycle, 0, 0) if isinstance(reply, Location) else reply)
                for cycle in range(6) for reply in order]
    whole = [status for status in statuses if status]
    assert [status.location.x for status in whole if status.location] == list(range(6))
    # In an unusual order the first status may come in two parts; after that the fields are known.
    assert all(replace(status, location=WHOLE.location) == WHOLE for status in whole[2:])


def test_it_tells_when_the_location_of_a_status_came():
    assembler = StatusAssembler()
    for now, reply in enumerate([*REPLIES, REPLIES[0]]):
        assembler.add(reply, now)
    assert assembler.located == REPLIES.index(WHOLE.location)
    assembler.drop()
    location_first = [WHOLE.location, *(r for r in REPLIES if r != WHOLE.location)]
    for now, reply in enumerate([*location_first, WHOLE.location], start=100):
        assembler.add(reply, now)
    assert assembler.located == 100


def test_an_older_robot_without_some_fields_is_understood():
    lines = ('Status: Stopped', 'BatteryVoltage: 26.1', 'Location: 1 2 3')
    assembler = StatusAssembler()
    statuses = [assembler.add(parse_line(line)) for _ in range(3) for line in lines]
    stopped = OneLineStatus('Stopped', battery_voltage=BatteryVoltage(26.1),
                            location=Location(1, 2, 3))
    assert [status for status in statuses if status] == [stopped] * 3
    assert statuses[3] == stopped, 'the first status must end at the first line of the second'


def test_a_status_on_one_line_is_whole_by_itself():
    status = parse_line('Status: Stopped Location: 1 2 3')
    assert StatusAssembler().add(status) == status


def test_other_lines_in_between_do_not_matter():
    assembler = StatusAssembler()
    statuses = [assembler.add(reply) for status in REPLIES * 2
                for reply in (status, parse_line('Going to 12'))]
    assert [status for status in statuses if status] == [WHOLE, WHOLE]
