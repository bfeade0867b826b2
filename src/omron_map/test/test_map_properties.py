"""For any map and any edits: untouched lines keep their bytes, and edits can be read back."""
from __future__ import annotations

import dataclasses
from typing import List

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from map_builders import map_bytes

from omron_map import DuplicateName, Extent, MapDocument, MapError, MapObject
from omron_map.objects import format_object

COORDINATES = st.integers(-900_000, 900_000)
ANGLES = st.floats(-180, 180, exclude_min=True).map(lambda angle: round(angle, 6) + 0.0)
NAMES = st.text(st.characters(blacklist_categories=('Cc', 'Cs'), blacklist_characters='"'),
                min_size=1, max_size=12)
EXTENTS = st.builds(Extent, COORDINATES, COORDINATES, COORDINATES, COORDINATES)


def _line(extent: Extent, name: str) -> MapObject:
    return MapObject.forbidden_line(extent.from_x, extent.from_y, extent.to_x, extent.to_y, name)


OBJECTS = st.one_of(
    st.builds(MapObject.goal, NAMES, COORDINATES, COORDINATES, st.none() | ANGLES, NAMES),
    st.builds(MapObject.dock, NAMES, COORDINATES, COORDINATES, ANGLES),
    st.builds(lambda extent, theta, name: MapObject(
        'ForbiddenArea', 0.0, 0.0, theta, name=name, extent=extent), EXTENTS, ANGLES, NAMES),
    st.builds(_line, EXTENTS, NAMES))
ROWS = st.lists(st.tuples(COORDINATES, COORDINATES), max_size=30)
LINES = st.lists(st.tuples(COORDINATES, COORDINATES, COORDINATES, COORDINATES), max_size=8)
GROUPS = st.lists(st.sampled_from([
    'CustomInfo: ConfigParam "Name=Word" "Desc=a "b"  c" "Value="', 'Unknown: 1  2', '', ' \t',
    'MapInfo: GoalType Name=Goal', '_Cairn: Goal 0 0 0 "" ICON "off"', 'RouteInfo: Task "x" 1',
])).map(lambda lines: ''.join(f'{line}\n' for line in lines))
LINE_ENDS = st.sampled_from([b'\n', b'\r\n'])


def unique(objects: List[MapObject]) -> List[MapObject]:
    seen = {}
    for obj in objects:
        seen.setdefault(obj.name.lower(), obj)
    return list(seen.values())


@st.composite
def files(draw) -> bytes:
    objects = unique(draw(st.lists(OBJECTS, max_size=6)))
    text = ''.join(f'{format_object(obj)}\n' for obj in objects)
    data = map_bytes(draw(ROWS), draw(LINES), text, draw(GROUPS), draw(st.integers(1, 100)))
    return data.replace(b'\n', draw(LINE_ENDS))


@given(files())
def test_a_document_writes_the_bytes_it_read(data):
    assert MapDocument.from_bytes(data).to_bytes() == data


@given(st.lists(OBJECTS, max_size=8).map(unique), files())
def test_objects_that_were_added_read_back_the_same(objects, data):
    document = MapDocument.from_bytes(data)
    added = []
    for obj in objects:
        try:
            document.add(obj)
        except DuplicateName:
            continue
        added.append(obj)
    again = MapDocument.from_bytes(document.to_bytes())
    assert again.objects == document.objects
    assert all(obj in again.objects for obj in added)
    assert (again.points == document.points).all() and (again.lines == document.lines).all()


EDITS = st.lists(st.tuples(st.sampled_from(['add', 'move', 'rename', 'remove']), OBJECTS,
                           st.integers(0, 100)), max_size=8)


@settings(max_examples=settings.default.max_examples * 3 // 5)
@given(files(), EDITS)
def test_any_edits_keep_every_line_that_is_no_objects(data, edits):
    document = MapDocument.from_bytes(data)
    for action, obj, choice in edits:
        present = document.objects
        before = document.to_bytes()
        try:
            if action == 'add':
                document.add(obj)
            elif present:
                chosen = present[choice % len(present)]
                if action == 'move':
                    document.move(chosen, obj.x, obj.y, obj.theta)
                elif action == 'rename':
                    document.rename(chosen, obj.name)
                else:
                    document.remove(chosen)
        except MapError:
            assert document.to_bytes() == before, 'a refused edit changed something'
    result = document.to_bytes()
    assert MapDocument.from_bytes(result).objects == document.objects
    assert _without_objects(result) == _without_objects(data)


def _without_objects(data: bytes) -> List[bytes]:
    return [line for line in data.splitlines(keepends=True) if not line.startswith(b'Cairn:')]


@given(st.lists(OBJECTS, max_size=10).map(unique), st.randoms())
def test_the_order_of_the_objects_does_not_depend_on_the_order_of_adding(objects, random):
    shuffled = list(objects)
    random.shuffle(shuffled)
    documents = [MapDocument.from_bytes(map_bytes([(0, 0)])) for _ in range(2)]
    for document, order in zip(documents, (objects, shuffled)):
        for obj in order:
            document.add(obj)
    assert documents[0].to_bytes() == documents[1].to_bytes()


BLANKS = st.sampled_from([' ', '  ', '\t', ' \t '])


@given(st.lists(st.tuples(COORDINATES, COORDINATES, BLANKS, st.booleans()), max_size=20))
def test_rows_are_the_same_numbers_however_they_are_spaced(rows):
    text = ''.join(f'{x}{blank}{y}{blank if trailing else ""}\n' for x, y, blank, trailing in rows)
    points = MapDocument.from_bytes(f'2D-Map\nDATA\n{text}'.encode()).points
    assert np.array_equal(points, np.array([row[:2] for row in rows]).reshape(-1, 2))


@settings(max_examples=3 * settings.default.max_examples)
@given(st.text('0123456789-+. x\n', max_size=24))
def test_rows_are_accepted_exactly_when_plain_python_would(text):
    """The fast check of all rows is compared with a simple reader, line by line."""
    def plain():
        rows = []
        for line in text.split('\n'):
            words = line.split()
            if words:
                x, y = words
                rows.append([_whole(x), _whole(y)])
        return rows

    try:
        expected = plain()
        if expected and np.ptp(expected, axis=0).max() > 2_000_000:
            expected = None
    except ValueError:
        expected = None
    try:
        found = MapDocument.from_bytes(f'2D-Map\nDATA\n{text}'.encode()).points.tolist()
    except MapError:
        found = None
    assert found == expected


def _whole(word: str) -> int:
    digits = word[1:] if word.startswith('-') else word
    if not digits.isdigit() or int(digits) >= 2**31:
        raise ValueError(word)
    return int(word)


@given(files())
def test_an_equal_object_is_as_good_as_the_documents_own(data):
    document = MapDocument.from_bytes(data)
    for obj in document.objects:
        document.remove(dataclasses.replace(obj))
    assert document.objects == ()
