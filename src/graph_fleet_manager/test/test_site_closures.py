"""What is closed stays closed, whatever dies, until somebody says otherwise."""
from __future__ import annotations

import pytest

from graph_fleet_manager.files.errors import FileError
from graph_fleet_manager.site.closures import Closures, OutOfDate

SECOND = 10**9
KNOWN = range(1, 10)


@pytest.fixture
def file(tmp_path):
    return tmp_path / 'folder' / 'closed.json'


def test_at_first_nothing_is_closed(file):
    assert (Closures(file).edges, Closures(file).stamp) == (frozenset(), 0)


def test_closures_are_there_again_after_a_restart(file):
    Closures(file).take([3, -4], 5 * SECOND, 6 * SECOND, KNOWN)
    again = Closures(file)
    assert (again.edges, again.stamp) == ({3, 4}, 5 * SECOND)


def test_each_message_replaces_the_one_before_and_an_empty_one_opens_all(file):
    closures = Closures(file)
    closures.take([3], 0, 1 * SECOND, KNOWN)
    closures.take([4], 0, 2 * SECOND, KNOWN)
    assert closures.edges == {4}
    closures.take([], 0, 3 * SECOND, KNOWN)
    assert Closures(file).edges == frozenset()


def test_unknown_edges_are_left_out_and_told(file):
    closures = Closures(file)
    assert closures.take([3, 99, -98, 0], 0, SECOND, KNOWN) == {99, 98, 0}
    assert closures.edges == {3}


def test_what_was_said_before_the_closure_in_force_is_left_out(file):
    closures = Closures(file)
    closures.take([3], 5 * SECOND, 5 * SECOND, KNOWN)
    for stamp in (4 * SECOND, 5 * SECOND):
        with pytest.raises(OutOfDate):
            closures.take([], stamp, 6 * SECOND, KNOWN)
    assert closures.edges == {3}


def test_a_clock_far_ahead_does_not_keep_others_from_opening(file):
    closures = Closures(file)
    closures.take([3], 3600 * SECOND, 5 * SECOND, KNOWN)
    closures.take([], 6 * SECOND, 6 * SECOND, KNOWN)
    assert closures.edges == frozenset()


def test_a_new_graph_forgets_what_it_does_not_have(file):
    closures = Closures(file)
    closures.take([3, 4], 0, SECOND, KNOWN)
    assert closures.forget_all_but([4]) == {3}
    assert Closures(file).edges == {4}


@pytest.mark.parametrize('text', ['', '[]', '{"edges": [1]}', '{"stamp": 1, "edges": ["x"]}',
                                  '{"stamp": null, "edges": []}'])
def test_a_damaged_file_opens_nothing_by_itself(file, text):
    file.parent.mkdir()
    file.write_text(text)
    with pytest.raises(FileError, match='does not say which edges are closed'):
        Closures(file)


def test_what_cannot_be_written_changes_nothing(tmp_path):
    (tmp_path / 'folder').write_text('a file in the way')
    with pytest.raises((OSError, FileError)):
        Closures(tmp_path / 'folder' / 'closed.json').take([3], 0, SECOND, KNOWN)
