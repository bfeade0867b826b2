"""A closed edge stays closed until it is opened, even after crashes."""
from __future__ import annotations

from pathlib import Path
from typing import List, Set, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.files.errors import FileError
from fleet_core.site.closures import (
    Closures,
    EdgeAction,
    EdgeOperation,
    OutOfDate,
    Repeated,
)

SECOND = 10**9
KNOWN = range(1, 10)
CLOSE, OPEN = EdgeAction.CLOSE, EdgeAction.OPEN


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / 'folder' / 'closed.json'


def operation(action: EdgeAction, *edges: int, identity: str = '') -> EdgeOperation:
    return EdgeOperation(action, frozenset(edges), identity)


def test_at_first_nothing_is_closed(file: Path) -> None:
    assert (Closures(file).edges, Closures(file).stamp) == (frozenset(), 0)


# --- operations on edges --------------------------------------------------------------------------


def test_an_operation_changes_its_own_edges_only(file: Path) -> None:
    closures = Closures(file)
    closures.apply(operation(CLOSE, 3, 4), SECOND, KNOWN)
    closures.apply(operation(CLOSE, 5), 2 * SECOND, KNOWN)
    closures.apply(operation(OPEN, 3, 6), 3 * SECOND, KNOWN)
    assert (closures.edges, closures.stamp) == ({4, 5}, 3 * SECOND)


def test_operations_are_there_again_after_a_restart(file: Path) -> None:
    Closures(file).apply(operation(CLOSE, 3), 5 * SECOND, KNOWN)
    again = Closures(file)
    assert (again.edges, again.stamp) == ({3}, 5 * SECOND)


@given(st.lists(st.tuples(st.sampled_from(EdgeAction), st.sets(st.integers(1, 9))), max_size=12),
       st.lists(st.integers(-10**9, 10**12), min_size=12, max_size=12))
def test_whatever_the_clocks_say_the_last_operation_on_an_edge_decides(
        tmp_path_factory: pytest.TempPathFactory,
        said: List[Tuple[EdgeAction, Set[int]]], clock: List[int]) -> None:
    closures = Closures(tmp_path_factory.mktemp('site') / 'closed.json')
    for (action, edges), now in zip(said, clock):
        assert closures.apply(operation(action, *edges), now, KNOWN) == frozenset()
    last = {edge: action for action, edges in said for edge in edges}
    assert closures.edges == {edge for edge, action in last.items() if action is CLOSE}


def test_two_operators_do_not_overwrite_each_other(file: Path) -> None:
    closures = Closures(file)
    closures.apply(operation(CLOSE, 3, identity='/edge_1 1 5'), SECOND, KNOWN)
    closures.apply(operation(CLOSE, 4, identity='/edge_2 1 5'), SECOND, KNOWN)
    assert closures.edges == {3, 4}, 'both messages have the same stamp'


def test_a_message_that_comes_again_is_carried_out_once(file: Path) -> None:
    """A latched message arrives again after its connection broke, or after graph_server restarted.
    """
    closures = Closures(file)
    first = operation(CLOSE, 3, identity='/editor 1 5000')
    closures.apply(first, SECOND, KNOWN)
    closures.apply(operation(OPEN, 3, identity='/other 1 4000'), 2 * SECOND, KNOWN)
    for again in (closures, Closures(file)):
        with pytest.raises(Repeated):
            again.apply(first, 3 * SECOND, KNOWN)
        assert again.edges == frozenset()
    closures.apply(operation(CLOSE, 3, identity='/editor 2 5000'), 4 * SECOND, KNOWN)
    assert closures.edges == {3}, 'the next message of a sender must count, regardless of its stamp'


def test_an_operation_without_an_identity_always_counts(file: Path) -> None:
    closures = Closures(file)
    for action, closed in ((CLOSE, {3}), (OPEN, set()), (CLOSE, {3})):
        closures.apply(operation(action, 3), SECOND, KNOWN)
        assert closures.edges == closed


def test_identities_do_not_grow_without_bound(file: Path) -> None:
    closures = Closures(file)
    for k in range(1100):
        closures.apply(operation(CLOSE, 3, identity=f'/edge_{k} 1 {k}'), SECOND, KNOWN)
    assert file.stat().st_size < 40_000


def test_edges_that_the_graph_lacks_are_told_and_not_closed(file: Path) -> None:
    closures = Closures(file)
    assert closures.apply(operation(CLOSE, 3, 99, 0), SECOND, KNOWN) == {99, 0}
    assert closures.apply(operation(OPEN, 98), SECOND, KNOWN) == {98}
    assert closures.edges == {3}


# --- without a graph ------------------------------------------------------------------------------


def test_without_a_graph_nothing_that_is_closed_is_forgotten(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3, 4], 0, SECOND, KNOWN)
    assert closures.replace([3, 5], 0, 2 * SECOND, None) == frozenset()
    assert closures.apply(operation(CLOSE, 77), 3 * SECOND, None) == frozenset()
    assert closures.apply(operation(OPEN, 5), 4 * SECOND, None) == frozenset()
    assert Closures(file).edges == {3, 77}


def test_a_new_graph_forgets_what_it_does_not_have(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3, 4], 0, SECOND, KNOWN)
    assert closures.forget_all_but([4]) == {3}
    assert Closures(file).edges == {4}


def test_what_was_carried_out_is_remembered_when_a_graph_is_replaced(file: Path) -> None:
    closures = Closures(file)
    said = operation(CLOSE, 3, 4, identity='/editor 1 5000')
    closures.apply(said, SECOND, KNOWN)
    closures.forget_all_but([4])
    closures.apply(operation(OPEN, 4), 2 * SECOND, KNOWN)
    with pytest.raises(Repeated):
        closures.apply(said, 3 * SECOND, KNOWN)
    assert closures.edges == frozenset()


# --- whole lists ----------------------------------------------------------------------------------


def test_closures_are_there_again_after_a_restart(file: Path) -> None:
    Closures(file).replace([3, -4], 5 * SECOND, 6 * SECOND, KNOWN)
    again = Closures(file)
    assert (again.edges, again.stamp) == ({3, 4}, 5 * SECOND)


def test_each_list_replaces_the_one_before_and_an_empty_one_opens_all(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3], 0, 1 * SECOND, KNOWN)
    closures.replace([4], 0, 2 * SECOND, KNOWN)
    assert closures.edges == {4}
    closures.replace([], 0, 3 * SECOND, KNOWN)
    assert Closures(file).edges == frozenset()


def test_unknown_edges_of_a_list_are_left_out_and_told(file: Path) -> None:
    closures = Closures(file)
    assert closures.replace([3, 99, -98, 0], 0, SECOND, KNOWN) == {99, 98, 0}
    assert closures.edges == {3}


def test_a_list_that_was_said_before_the_closure_in_force_is_out_of_date(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3], 5 * SECOND, 5 * SECOND, KNOWN)
    for stamp in (4 * SECOND, 5 * SECOND):
        with pytest.raises(OutOfDate):
            closures.replace([], stamp, 6 * SECOND, KNOWN)
    assert closures.edges == {3}


def test_a_list_that_was_said_before_an_operation_does_not_undo_it(file: Path) -> None:
    closures = Closures(file)
    closures.apply(operation(CLOSE, 3), 5 * SECOND, KNOWN)
    with pytest.raises(OutOfDate):
        closures.replace([], 4 * SECOND, 6 * SECOND, KNOWN)
    assert closures.edges == {3}


def test_a_clock_far_ahead_does_not_keep_others_from_opening(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3], 3600 * SECOND, 5 * SECOND, KNOWN)
    closures.replace([], 6 * SECOND, 6 * SECOND, KNOWN)
    assert closures.edges == frozenset()


def test_lists_count_after_the_clock_of_the_computer_was_set_back(file: Path) -> None:
    closures = Closures(file)
    closures.replace([3], 0, 3600 * SECOND, KNOWN)
    closures.replace([4], 10 * SECOND, 10 * SECOND, KNOWN)
    assert (closures.edges, closures.stamp) == ({4}, 10 * SECOND)


# --- the file -------------------------------------------------------------------------------------


def test_a_file_from_before_operations_is_read(file: Path) -> None:
    file.parent.mkdir()
    file.write_text('{"stamp": 7, "edges": [3]}\n')
    assert (Closures(file).edges, Closures(file).stamp) == ({3}, 7)


@pytest.mark.parametrize('text', ['', '[]', '{"edges": [1]}', '{"stamp": 1, "edges": ["x"]}',
                                  '{"stamp": null, "edges": []}',
                                  '{"stamp": 1, "edges": [], "carried_out": 5}'])
def test_a_damaged_file_opens_nothing_by_itself(file: Path, text: str) -> None:
    file.parent.mkdir()
    file.write_text(text)
    with pytest.raises(FileError, match='does not say which edges are closed'):
        Closures(file)


def test_what_cannot_be_written_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / 'folder').write_text('a file in the way')
    with pytest.raises((OSError, FileError)):
        Closures(tmp_path / 'folder' / 'closed.json').replace([3], 0, SECOND, KNOWN)


def test_an_operation_that_cannot_be_written_changes_nothing_and_may_come_again(
        file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    closures = Closures(file)
    said = operation(CLOSE, 3, identity='/editor 1 5000')

    def full(*_: object) -> None:
        raise OSError('the disk is full')
    with monkeypatch.context() as patch:
        patch.setattr('fleet_core.site.closures.replace_file', full)
        with pytest.raises(OSError, match='full'):
            closures.apply(said, SECOND, KNOWN)
        assert (closures.edges, closures.stamp) == (frozenset(), 0)
    closures.apply(said, 2 * SECOND, KNOWN)
    assert closures.edges == {3}
