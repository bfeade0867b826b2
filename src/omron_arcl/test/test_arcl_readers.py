"""Every number is checked when it is read, and names are returned without their quotes."""
from __future__ import annotations

import struct

import pytest

from omron_arcl import ignored_fields, parse_line
from omron_arcl.readers import unquoted
from omron_arcl.replies import (
    ArrivedAt,
    BatteryVoltage,
    Goal,
    GoingTo,
    LocalizationScore,
    Location,
    MapObjectCoord,
    OneLineStatus,
    StateOfCharge,
    Temperature,
    UnknownLine,
)


@pytest.mark.parametrize(('prefix', 'kind', 'good', 'bad'), [
    ('StateOfCharge', StateOfCharge, ('0', '100', '79.4'), ('-0.1', '100.1', '1e41', 'nan')),
    ('BatteryVoltage', BatteryVoltage, ('0', '26.1', '1e3'), ('-1', '1001', 'inf', '1e39')),
    ('LocalizationScore', LocalizationScore, ('0', '1', '0.170543'), ('-0.1', '1.1', 'nan')),
    ('Temperature', Temperature, ('36', '-128', '-40'), ('1e4', '-200', 'nan', '-inf')),
    ('Location', Location, ('1 2 3', '-1e10 1e10 -180', '0 0 360'),
     ('1e308 0 0', '0 -1e11 0', '0 0 361', 'nan 0 0', '0 0 inf', '1_0 0 0', '1 2', '1 2 3 4')),
    ('MapObjectInfoCoord', MapObjectCoord, ('"x" 1 2 90.0',), ('"x" 1e11 2 90', '"x" 1 2 1e9')),
])
def test_a_number_that_cannot_be_is_no_measurement(prefix, kind, good, bad):
    for text in good:
        assert isinstance(parse_line(f'{prefix}: {text}'), kind), text
    for text in bad:
        assert isinstance(parse_line(f'{prefix}: {text}'), UnknownLine), text


def test_the_largest_measurements_fit_a_float32():
    for line in ('StateOfCharge: 100', 'BatteryVoltage: 1000', 'Temperature: 1000'):
        (value,) = vars(parse_line(line)).values()
        struct.pack('<f', value)
    location = parse_line('Location: 1e10 -1e10 360')
    struct.pack('<3f', location.x, location.y, location.heading)


def test_a_bad_field_costs_a_status_on_one_line_only_that_field():
    status = parse_line('Status: Going to 12 StateOfCharge: 1e41 Location: 1 2 3 Temperature: hot')
    assert status == OneLineStatus('Going to 12', location=Location(1, 2, 3),
                                   ignored=('StateOfCharge: 1e41', 'Temperature: hot'))
    assert ignored_fields(status) == ('StateOfCharge: 1e41', 'Temperature: hot')


@pytest.mark.parametrize(('line', 'fields'), [
    ('StateOfCharge: 123', ('StateOfCharge: 123',)), ('Location: nan 0 0', ('Location: nan 0 0',)),
    ('StateOfCharge: 79.4', ()), ('Temperature: -127', ()), ('hello', ()), ('Goal:', ()),
    ('Status: Stopped Location: 1 2 3', ())])
def test_impossible_values_are_told_also_those_on_lines_of_their_own(line, fields):
    assert ignored_fields(parse_line(line)) == fields


@pytest.mark.parametrize(('line', 'reply'), [
    ('Goal: "charger1"', Goal('charger1')), ('Goal: charger 1', Goal('charger 1')),
    ('Goal: "goal space"', Goal('goal space')), ('Going to "charger1"', GoingTo('charger1')),
    ('Arrived at "charger1"', ArrivedAt('charger1')), ('Goal: "', Goal('"')),
    ('Goal: ""', Goal('""')), ('Goal: "a" "b"', Goal('"a" "b"')),
])
def test_names_come_without_the_quotes_around_them(line, reply):
    assert parse_line(line) == reply


def test_quotes_within_a_name_are_part_of_it():
    assert unquoted('a "b" c') == 'a "b" c'
    assert unquoted('"a" and "b"') == '"a" and "b"'
