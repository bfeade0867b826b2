"""Names of European sites are displayed correctly in each encoding, and kept byte for byte."""
from __future__ import annotations

import pytest
from map_builders import CELL

from omron_map import DuplicateName, MapDocument, MapError, MapObject
from omron_map.text import decode, encode, printable

ENCODINGS = ['utf-8', 'latin-1']


def kitchen(encoding: str) -> MapDocument:
    """Returns a map with the goal `Küche`, and a route that names it."""
    lines = 'RouteInfo: GoalAfter "Küche"\nCairn: Goal 20 20 0.000000 "für alle" ICON "Küche"\n'
    return MapDocument.from_bytes(CELL.replace(
        b'Cairn: Goal 20 20 0.000000 "" ICON "North"\n', lines.encode(encoding)))


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_a_name_is_read_and_found_in_whichever_encoding_it_is(encoding):
    document = kitchen(encoding)
    goal, = document.goals
    assert goal.label == 'Küche' and str(goal) == "Goal 'Küche'"
    assert document.find('KÜCHE') is goal
    assert document.warnings == ()


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_an_edit_leaves_the_encoding_of_the_line_as_it_was(encoding):
    document = kitchen(encoding)
    before = document.to_bytes()
    document.move(document.goals[0], 30, 20)
    assert document.to_bytes() == before.replace(b'Goal 20 20', b'Goal 30 20')


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_the_same_name_in_another_encoding_is_no_other_name(encoding):
    with pytest.raises(DuplicateName, match="there is a Goal 'Küche' already"):
        kitchen(encoding).add(MapObject.goal('Küche', 0, 0))


def test_a_renamed_goal_takes_its_references_along():
    document = kitchen('latin-1')
    document.rename(document.goals[0], 'Saal')
    assert b'GoalAfter "Saal"' in document.to_bytes()


@pytest.mark.parametrize('raw', [b'K\xfcche', 'Küche'.encode(), b'\xff\xfe\x00', bytes(range(256))])
def test_bytes_are_kept_whatever_they_mean(raw):
    assert encode(decode(raw)) == raw


@pytest.mark.parametrize('raw, shown', [
    (b'K\xfcche', 'Küche'), ('Küche 門'.encode(), 'Küche 門'), (b'Caf\xe9 \x93X\x94', 'Café “X”'),
    (b'a\x1b[2Jb', 'a\ufffd[2Jb'), (b'\x81\xfc', '\ufffdü'), (b'a\tb', 'a\ufffdb')])
def test_people_are_shown_letters(raw, shown):
    assert printable(decode(raw)) == shown


@pytest.mark.parametrize('name', ['\ud800', 'a\x85b', 'a\nb'])
def test_a_name_that_no_file_can_hold_is_refused_in_words(name):
    with pytest.raises(MapError, match='cannot be written'):
        kitchen('utf-8').add(MapObject.goal(name, 0, 0))


def test_a_kind_in_another_encoding_can_be_told_of():
    document = MapDocument.from_bytes(CELL.replace(b'Cairn: Goal', b'Cairn: R\xfcckGoal'))
    assert str(document.objects[0]) == "RückGoal 'North'"
