"""The goal that a click on the map selects."""
from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omron_arcl import InvalidCommand
from omron_ld90.operator.goal_clicks import (
    Target,
    TargetKind,
    explain_miss,
    resolve_click,
    target_named,
    targets_of,
)
from omron_map import MapDocument

TOLERANCE = 0.5
MAP = b'''2D-Map
Cairn: Goal 1000 2000 0.000000 "" ICON "12"
Cairn: GoalWithHeading -1500 0 90.000000 "" ICON "Meeting room"
Cairn: DockLynx 4000 0 180.000000 "" ICON "Dock 1"
Cairn: ForbiddenArea 0 0 0.000000 "" ICON "Stairs" 0 0 1000 1000
DATA
'''
coordinates = st.floats(-50.0, 50.0)


def goal(name: str, x: float, y: float) -> Target:
    return Target(TargetKind.GOAL, name, x, y)


@pytest.fixture
def targets():
    return targets_of(MapDocument.from_bytes(MAP))


def test_goals_and_docks_are_targets_in_metres_and_areas_are_not(targets):
    assert [(target.kind, target.name, target.x, target.y) for target in targets] == [
        (TargetKind.GOAL, '12', 1.0, 2.0),
        (TargetKind.GOAL, 'Meeting room', -1.5, 0.0),
        (TargetKind.DOCK, 'Dock 1', 4.0, 0.0)]


@pytest.mark.parametrize('encoding', ['utf-8', 'latin-1'])
def test_a_name_reads_the_same_in_whichever_encoding_the_file_is(encoding):
    kitchen = '2D-Map\nCairn: Goal 0 0 0.000000 "" ICON "Küche"\nDATA\n'.encode(encoding)
    target, = targets_of(MapDocument.from_bytes(kitchen))
    assert target.name == 'Küche' and str(target) == 'goal Küche'
    assert target_named('KÜCHE', [target]) is target


def test_a_name_that_no_command_can_hold_is_told_when_it_is_sent_and_not_before():
    quoted = b'2D-Map\nCairn: Goal 0 0 0.000000 "" ICON "in"ner"\nDATA\n'
    target, = targets_of(MapDocument.from_bytes(quoted))
    assert str(target) == 'goal in"ner'
    with pytest.raises(InvalidCommand, match='double quote'):
        target.command  # noqa: B018  a property


def test_only_a_target_with_a_heading_has_one(targets):
    assert [target.heading for target in targets] == [None, 90.0, 180.0]


def test_a_goal_is_gone_to_by_name_and_a_dock_is_docked_at(targets):
    assert [target.command for target in targets] == [
        'goto 12', 'goto "Meeting room"', 'dock']


def test_the_nearest_target_within_the_tolerance_is_meant():
    near, far = goal('near', 0.3, 0.0), goal('far', -0.4, 0.0)
    click = resolve_click([far, near], 0.0, 0.0, TOLERANCE)
    assert click.hit
    assert click.target is near
    assert click.distance == pytest.approx(0.3)


def test_a_click_at_the_tolerance_hits_and_one_beyond_it_misses():
    targets = [goal('12', 0.5, 0.0)]
    assert resolve_click(targets, 0.0, 0.0, TOLERANCE).hit
    assert not resolve_click(targets, -0.001, 0.0, TOLERANCE).hit


def test_a_miss_says_what_would_have_been_nearest():
    click = resolve_click([goal('12', 2.0, 0.0)], 0.0, 0.0, TOLERANCE)
    assert explain_miss(click, TOLERANCE) == (
        'Nothing within 0.50 m of the click: goal 12 is the nearest, 2.00 m away.')


def test_a_map_without_targets_is_always_missed():
    click = resolve_click([], 0.0, 0.0, TOLERANCE)
    assert not click.hit
    assert explain_miss(click, TOLERANCE) == 'Nothing there: the map has no goal and no dock.'


@given(st.lists(st.tuples(coordinates, coordinates), min_size=1), coordinates, coordinates)
def test_no_target_is_nearer_than_the_one_that_is_meant(places, x, y):
    targets = [goal(str(index), *place) for index, place in enumerate(places)]
    click = resolve_click(targets, x, y, TOLERANCE)
    assert all(click.distance <= math.hypot(px - x, py - y) for px, py in places)
    assert click.hit == (click.distance <= TOLERANCE)


@pytest.mark.parametrize(('name', 'place'), [('12', (1.0, 2.0)), ('MEETING room', (-1.5, 0.0))])
def test_a_target_is_found_by_its_name_whatever_its_case(name, place):
    assert target_named(name, targets_of(MapDocument.from_bytes(MAP))).place == place


def test_a_name_that_the_map_does_not_have_is_no_target():
    assert target_named('13', targets_of(MapDocument.from_bytes(MAP))) is None
