"""The meaning of the kinds of objects, and the text of a new object."""
from __future__ import annotations

import math

import pytest

from omron_map import Extent, MapObject, RotatedRectangle
from omron_map.errors import FieldError
from omron_map.objects import format_object, parse_object
from omron_map.tokens import tokenise

KINDS = [  # kind, goal, dock, heading
    ('Goal', True, False, False), ('GoalWithHeading', True, False, True),
    ('StandbyGoal', True, False, False), ('StandbyGoalWithHeading', True, False, True),
    ('DoorGoal', True, False, False), ('Dock', False, True, True),
    ('DockLynx', False, True, True), ('DockHD', False, True, True),
    ('LynxDockTarget', False, False, True), ('RobotHome', False, False, True),
    ('Label', False, False, False),
]


def parse(line: str) -> MapObject:
    return parse_object(line, tokenise(line))


@pytest.mark.parametrize('kind, goal, dock, heading', KINDS)
def test_the_kind_says_what_an_object_is(kind, goal, dock, heading):
    obj = MapObject(kind, 1.0, 2.0, 3.0)
    assert (obj.is_goal, obj.is_dock, obj.has_heading) == (goal, dock, heading)


@pytest.mark.parametrize('obj, line', [
    (MapObject.goal('A 1', 10, -20), 'Cairn: Goal 10 -20 0.000000 "" ICON "A 1"'),
    (MapObject.goal('B', 0.4, -0.4, heading=-450, description='d'),
     'Cairn: GoalWithHeading 0 0 -90.000000 "d" ICON "B"'),
    (MapObject.dock('D', 1, 2, -180.0), 'Cairn: DockLynx 1 2 180.000000 "" ICON "D"'),
    (MapObject.dock('D', 1, 2, -1e-9, kind='DockHD'), 'Cairn: DockHD 1 2 0.000000 "" ICON "D"'),
    (MapObject.forbidden_area(RotatedRectangle(3000, 3000, 2000, 1000, 30), 'F'),
     'Cairn: ForbiddenArea 0 0 30.000000 "" ICON "F" 3098 598 5098 1598'),
    (MapObject.forbidden_line(1, 2, 3, 4),
     'Cairn: ForbiddenLine 1 2 0.000000 "" ICON "" 1 2 3 4'),
])
def test_a_new_object_is_written_as_the_vendors_tools_do(obj, line):
    assert format_object(obj) == line
    assert format_object(parse(line)) == line


def test_areas_are_known_from_lines_and_from_configuration():
    area = parse('Cairn: ForbiddenArea 0 0 90.000000 "" ICON "A" 1000 -3000 4000 -1000')
    assert area.is_area and area.rectangle.centre_x == 2000.0
    line = parse('Cairn: Measure 1 2 0.000000 "" ICON "" 1 2 3 4')
    assert line.is_line and not line.is_area and line.extent == Extent(1, 2, 3, 4)
    replies = parse('Cairn: FeedbackHandler 0 0 0.000000 "" ICON "R" 0 0 0 0')
    assert not replies.is_area and not replies.is_line
    with pytest.raises(ValueError, match='not an area'):
        _ = replies.rectangle


def test_a_tail_is_kept_word_by_word_with_its_quotes():
    line = 'Cairn: MotionLimitsSector 0 0 0.000000 "" ICON "P" 0 0 4 4 3 0 0 4 0 4 4 "a b"'
    obj = parse(line)
    assert obj.tail[-1] == '"a b"' and obj.polygon is None
    assert format_object(obj) == line


def test_an_unknown_kind_keeps_whatever_follows_its_name():
    obj = parse('Cairn: Lamp.Red 1 2 0.000000 "" ICON "L" on off')
    assert obj.extent is None and obj.tail == ('on', 'off')


@pytest.mark.parametrize('obj, words', [
    (MapObject.goal('', 0, 0), 'empty'),
    (MapObject.goal('say "hi"', 0, 0), 'double quote'),
    (MapObject.goal('A', 0, 0, description='a\nb'), 'line break'),
    (MapObject.goal('A', math.nan, 0), 'finite'),
    (MapObject.goal('A', 0, 0, heading=math.inf), 'finite'),
    (MapObject.goal('A' * 10_000, 0, 0), '10000 bytes'),
    (MapObject('Goal x', 0, 0, 0, name='A'), 'one word'),
    (MapObject('Goal', 0, 0, 0, icon='', name='A'), 'one word'),
    (MapObject.forbidden_line(0, 0, 3e9, 0), '32 bits'),
])
def test_what_the_format_cannot_hold_is_refused(obj, words):
    with pytest.raises(FieldError) as caught:
        format_object(obj)
    assert words in f'{caught.value.problem} {caught.value.expected}'
