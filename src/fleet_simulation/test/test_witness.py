"""The witness reports each broken promise, and nothing else."""
from __future__ import annotations

import ast
from pathlib import Path
from typing import Dict, Sequence, Tuple

import pytest

from world.witness import State, Witness, growth

GRACE = 2.0
VERTICES = {1: (0.0, 0.0), 2: (5.0, 0.0), 3: (5.0, 5.0)}
FAR = (50.0, 50.0)


@pytest.fixture
def witness() -> Witness:
    return Witness({'a': 0.4, 'b': 0.4}, 0.1, VERTICES, GRACE)


def judge(witness: Witness, now: float, a: Tuple[float, float],
          b: Tuple[float, float] = FAR) -> None:
    places: Dict[str, Tuple[float, float]] = {'a': a, 'b': b}
    witness.judge(now, places, places)


def drive(witness: Witness, *places: Tuple[float, float], since: float = 0.0) -> None:
    for count, place in enumerate(places):
        judge(witness, since + 0.1 * count, place)


def is_told(witness: Witness, state: State, robot: str = 'a', reached: int = 0) -> None:
    witness.hear(7, state, robot, reached, 'for some reason')


def test_it_names_two_robots_that_are_too_near_once(witness: Witness) -> None:
    for now in (0.0, 0.1):
        judge(witness, now, (0.0, 0.0), (0.8, 0.0))
    assert len(witness.broken) == 1
    assert 'a and b are too near by 0.10 m' in witness.broken[0]


def test_robots_are_too_near_in_both_looks_or_not_at_all(witness: Witness) -> None:
    witness.judge(0.0, {'a': (0.0, 0.0), 'b': (0.8, 0.0)}, {'a': (0.0, 0.0), 'b': (1.0, 0.0)})
    assert witness.broken == []


def test_distances_of_a_carried_robot_count_again_once_it_is_back_and_clear(
        witness: Witness) -> None:
    witness.carry('a', 0.0)
    judge(witness, 0.0, (0.0, 0.0), (0.5, 0.0))
    witness.bring_back('a')
    judge(witness, 0.1, (0.0, 0.0), (0.5, 0.0))
    assert witness.broken == []
    judge(witness, 0.2, (0.0, 0.0), (2.0, 0.0))
    judge(witness, 0.3, (0.0, 0.0), (0.5, 0.0))
    assert len(witness.broken) == 1


def test_a_mission_may_fail_by_a_robot_that_a_person_moves_near_to_its_own(
        witness: Witness) -> None:
    witness.ask(7, [1], 0.0)
    is_told(witness, State.ACTIVE)
    witness.carry('b', 0.5)
    judge(witness, 1.0, (0.0, 0.0), (1.2, 0.0))
    is_told(witness, State.FAILED)
    assert witness.broken == []


@pytest.mark.parametrize('middle, broken', [(1.2, 0), (1.6, 1)])
def test_a_mission_may_fail_by_a_robot_that_stopped_because_of_a_carried_one(
        middle: float, broken: int) -> None:
    witness = Witness(dict.fromkeys('abc', 0.4), 0.1, VERTICES, GRACE)
    witness.ask(7, [1], 0.0)
    is_told(witness, State.ACTIVE)
    witness.carry('c', 0.5)
    places = {'a': (0.0, 0.0), 'b': (middle, 0.0), 'c': (2.4, 0.0)}
    witness.judge(1.0, places, places)
    is_told(witness, State.FAILED)
    assert len(witness.broken) == broken


def test_a_mission_may_not_fail_by_a_carried_robot_that_is_far(witness: Witness) -> None:
    witness.ask(7, [1], 0.0)
    is_told(witness, State.ACTIVE)
    witness.carry('b', 0.5)
    judge(witness, 1.0, (0.0, 0.0), (3.0, 0.0))
    is_told(witness, State.FAILED)
    assert len(witness.broken) == 1


def test_a_stopped_robot_may_be_carried_and_must_rest_afterwards(witness: Witness) -> None:
    witness.stop(['a'], 0.0)
    judge(witness, 3.0, (1.0, 0.0))
    witness.carry('a', 3.1)
    judge(witness, 4.0, (5.0, 0.0))
    witness.bring_back('a')
    judge(witness, 4.1, (5.0, 0.0))
    judge(witness, 4.2, (5.0, 0.0))
    assert witness.broken == []
    judge(witness, 5.0, (6.0, 0.0))
    assert 'a drives 5.0 s after it was stopped' in witness.broken[0]


def test_a_stopped_robot_may_come_to_rest_and_not_drive_on(witness: Witness) -> None:
    witness.stop(['a'], 0.0)
    judge(witness, 1.0, (1.0, 0.0))
    judge(witness, 2.1, (2.0, 0.0))
    assert witness.broken == []
    judge(witness, 3.0, (2.5, 0.0))
    assert 'a drives 3.0 s after it was stopped' in witness.broken[0]


def test_a_robot_that_was_let_go_may_drive(witness: Witness) -> None:
    witness.stop(['a'], 0.0)
    judge(witness, 2.1, (2.0, 0.0))
    witness.release(['a'])
    judge(witness, 9.0, (3.0, 0.0))
    assert witness.broken == []


def test_a_stop_counts_once_the_robot_can_be_reached(witness: Witness) -> None:
    witness.cut(['a'])
    witness.stop(['a'], 0.0)
    judge(witness, 5.0, (2.0, 0.0))
    judge(witness, 6.0, (3.0, 0.0))
    witness.mend(['a'], 6.0)
    judge(witness, 7.0, (4.0, 0.0))
    assert witness.broken == []
    judge(witness, 8.1, (5.0, 0.0))
    judge(witness, 8.2, (5.5, 0.0))
    assert len(witness.broken) == 1


def test_a_mission_succeeds_where_its_robot_was_everywhere_in_order(witness: Witness) -> None:
    witness.ask(7, [2, 3], 0.0)
    drive(witness, (0.0, 0.0), (2.5, 0.0), (5.0, 0.0), (5.0, 2.5), (5.0, 5.0))
    is_told(witness, State.ACTIVE)
    is_told(witness, State.SUCCEEDED)
    assert witness.broken == []
    assert witness.ends()[State.SUCCEEDED] == 1


def test_a_success_that_is_heard_before_the_last_visit_is_sampled_counts(witness: Witness) -> None:
    witness.ask(7, [2], 0.0)
    drive(witness, (0.0, 0.0), (2.5, 0.0))
    is_told(witness, State.SUCCEEDED)
    drive(witness, (2.5, 0.0), (5.0, 0.0), (5.0, 0.0), since=0.3)
    witness.end()
    assert witness.broken == []


def test_a_visit_that_is_missing_at_the_end_of_the_run_is_named(witness: Witness) -> None:
    witness.ask(7, [2], 0.0)
    drive(witness, (0.0, 0.0), (2.5, 0.0))
    is_told(witness, State.SUCCEEDED)
    witness.end()
    assert 'did not visit [2]' in witness.broken[0]


@pytest.mark.parametrize('destinations, missed', [([3, 2], '[2]'), ([1, 2], '[1, 2]')])
def test_a_success_without_the_visits_is_named(witness: Witness, destinations: Sequence[int],
                                               missed: str) -> None:
    drive(witness, (0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
    witness.ask(7, destinations, 5.0)
    drive(witness, (4.0, 0.0), (5.0, 0.0), (5.0, 2.5), (5.0, 5.0), since=5.0)
    is_told(witness, State.SUCCEEDED)
    drive(witness, (5.0, 5.0), (5.0, 5.0), since=6.0)
    assert missed in witness.broken[0]


def test_an_end_is_told_again_and_no_other_end(witness: Witness) -> None:
    witness.ask(7, [1], 0.0)
    judge(witness, 0.0, (0.0, 0.0))
    for _ in range(2):
        is_told(witness, State.SUCCEEDED)
    assert witness.broken == []
    is_told(witness, State.ACTIVE)
    assert 'ended as SUCCEEDED, then it was ACTIVE' in witness.broken[0]


def test_destinations_that_were_reached_stay_so(witness: Witness) -> None:
    witness.ask(7, [1, 2], 0.0)
    is_told(witness, State.ACTIVE, reached=1)
    is_told(witness, State.ACTIVE)
    assert len(witness.broken) == 1


@pytest.mark.parametrize('state', [State.REFUSED, State.CANCELLED, State.FAILED])
def test_an_end_without_a_cause_is_named(witness: Witness, state: State) -> None:
    witness.trouble('a', 0.0)
    witness.ask(7, [1], 1.0)
    is_told(witness, State.ACTIVE)
    is_told(witness, state)
    assert len(witness.broken) == 1
    assert 'for some reason' in witness.broken[0]


def test_an_end_with_a_cause_is_right(witness: Witness) -> None:
    witness.ask(7, [1], 0.0)
    is_told(witness, State.ACTIVE)
    witness.trouble('a', 1.0)
    is_told(witness, State.FAILED)
    witness.ask(8, [1], 2.0)
    witness.cancel(8)
    witness.hear(8, State.CANCELLED, '', 0, '')
    assert witness.broken == []


def test_a_mission_that_never_ends_is_named(witness: Witness) -> None:
    witness.ask(7, [1], 0.0)
    is_told(witness, State.ACTIVE)
    assert witness.open_missions == [7]
    witness.end()
    assert 'mission 7 over [1] never ended; last state ACTIVE, robot a' in witness.broken[0]


def test_of_a_mission_of_somebody_else_nothing_is_known(witness: Witness) -> None:
    is_told(witness, State.FAILED)
    assert witness.broken == []


@pytest.mark.parametrize('samples, grown', [
    ([1.0, 5.0, 5.0, 5.0], None), ([1.0, 5.0, 8.0, 9.0], (5.0, 9.0)), ([5.0, 5.0, 5.0, 5.5], None),
    ([], None)])
def test_growth_is_what_comes_after_the_first_quarter(
        samples: Sequence[float], grown: object) -> None:
    assert growth(samples, 0.2, 1.0) == grown


# -- the witness and the other judges observe from outside -----------------------------------------

WORLD = sorted((Path(__file__).parent / 'world').glob('*.py'))
OWN = {'_replace', '_fields', '_asdict'}  # these members of a NamedTuple are public
SELF = ast.Name('self', ast.Load())


def private_members(source: str) -> Sequence[str]:
    """Returns the private members of other objects that a module reads, changes or imports."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Attribute) and ast.dump(node.value) != ast.dump(SELF):
            found.append(node.attr)
        elif isinstance(node, ast.ImportFrom):
            found += [part for name in node.names for part in (node.module or '', name.name)]
    return [name for name in found
            if name.startswith('_') and not name.startswith('__') and name not in OWN]


@pytest.mark.parametrize('file', WORLD, ids=lambda file: file.stem)
def test_the_world_of_the_tests_reaches_into_no_private_member(file: Path) -> None:
    assert private_members(file.read_text(encoding='utf-8')) == []


@pytest.mark.parametrize('line', [
    'fleet._orders.clear()', 'fleet._orders = []', 'self.fleet._orders', 'super()._plan()',
    'from fleet import _Orders'])
def test_a_private_member_is_found(line: str) -> None:
    assert private_members(line) != []


def test_the_witness_knows_no_code_of_the_fleet() -> None:
    tree = ast.parse((WORLD[0].parent / 'witness.py').read_text(encoding='utf-8'))
    imported = {(node.module or '').split('.')[0] if isinstance(node, ast.ImportFrom) else
                node.names[0].name for node in ast.walk(tree)
                if isinstance(node, (ast.Import, ast.ImportFrom))}
    assert imported == {'__future__', 'dataclasses', 'enum', 'itertools', 'math', 'statistics',
                        'typing'}
