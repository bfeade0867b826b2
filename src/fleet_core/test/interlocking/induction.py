"""Proofs by induction with z3: each action of a system keeps all of its invariants.

A system consists of relations between things, such as robots and places. There may be any number of
things, so a proof holds for every site and every fleet. An action has guards, which must hold
before the action, and an effect: a formula over the relations before and after the action.

This module needs the package z3-solver, which scripts/test.sh installs in build/z3. Without z3, the
tests of each module that imports this one are skipped.
"""
from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Tuple

import pytest

sys.path += map(str, Path(__file__).resolve().parents[4].glob('build/z3/lib/*/site-packages'))
z3 = pytest.importorskip('z3', reason='z3-solver is not installed: scripts/test.sh installs it '
                                      'from PyPI in build/z3')

PATIENCE = 20_000  # ms for one check by z3, which usually takes some milliseconds

Formula = Any  # z3 has no types
Relations = Dict[str, Callable[..., Formula]]


class Action(NamedTuple):
    """One action: its guards, each under its name, and its effect."""

    guards: Dict[str, Formula]
    effect: List[Formula]


class System:
    """Relations before and after an action, by name, and the invariants that must hold for them.

    sorts -- for each relation, the sorts of the two things that it relates
    """

    def __init__(self, sorts: Dict[str, Tuple[Any, Any]],
                 invariants: Callable[[Relations], Dict[str, Formula]]) -> None:
        self._sorts = sorts
        self.before = self._relations('')
        self.after = self._relations(' afterwards')
        self._invariants = invariants

    def _relations(self, suffix: str) -> Relations:
        return {name: z3.Function(name + suffix, *sorts, z3.BoolSort())
                for name, sorts in self._sorts.items()}

    def with_changes(self, **changes: Callable[[Any, Any], Formula]) -> List[Formula]:
        """Returns the effect that changes these relations to these formulas, and no others."""
        return [self._is_after(name, changes.get(name, self.before[name])) for name in self._sorts]

    def with_arbitrary(self, name: str, only: Any) -> List[Formula]:
        """Returns the effect that changes one relation of one thing arbitrarily, and nothing else.
        """
        def unchanged(thing: Any, other: Any) -> Formula:
            return z3.If(thing == only, self.after[name](thing, other),
                         self.before[name](thing, other))

        return self.with_changes(**{name: unchanged})

    def adding(self, name: str, thing: Any, other: Any) -> Callable[[Any, Any], Formula]:
        """Returns the relation with one more pair."""
        return lambda x, y: z3.Or(self.before[name](x, y), z3.And(x == thing, y == other))

    def removing(self, name: str, thing: Any, other: Any) -> Callable[[Any, Any], Formula]:
        """Returns the relation without one pair."""
        return lambda x, y: z3.And(self.before[name](x, y), z3.Or(x != thing, y != other))

    def _is_after(self, name: str, formula: Callable[[Any, Any], Formula]) -> Formula:
        x, y = (z3.Const(letter, sort) for letter, sort in zip('xy', self._sorts[name]))
        return z3.ForAll([x, y], self.after[name](x, y) == formula(x, y))

    def broken_by(self, action: Action, without: Optional[str] = None) -> Dict[str, str]:
        """Returns the invariants that do not hold after the action, each with z3's answer.

        without -- the name of a guard to leave out
        """
        answers = {}
        for name, goal in self._invariants(self.after).items():
            solver = z3.Solver()
            solver.set('timeout', PATIENCE)
            solver.add(*self._invariants(self.before).values(), *action.effect, z3.Not(goal),
                       *(guard for words, guard in action.guards.items() if words != without))
            answer = solver.check()
            if answer != z3.unsat:
                answers[name] = str(answer)
        return answers

    def is_consistent(self) -> bool:
        """Returns whether a state with at least one pair in each relation is possible.

        If the invariants contradicted each other, every proof would succeed.
        """
        solver = z3.Solver()
        solver.set('timeout', PATIENCE)
        solver.add(*self._invariants(self.before).values())
        for name, sorts in self._sorts.items():
            x, y = (z3.Const(letter, sort) for letter, sort in zip('xy', sorts))
            solver.add(z3.Exists([x, y], self.before[name](x, y)))
        return bool(solver.check() == z3.sat)


def proof_of(system: System, actions: Dict[str, Action], needed_for: Dict[str, str]) -> type:
    """Returns the tests of a proof, as a class for pytest.

    needed_for -- for each guard, an invariant that breaks without the guard
    """
    guards = [(name, guard) for name, action in actions.items() for guard in action.guards]

    class Proof:
        def test_the_invariants_do_not_contradict_each_other(self) -> None:
            assert system.is_consistent()

        @pytest.mark.parametrize('name', actions)
        def test_each_action_keeps_all_invariants(self, name: str) -> None:
            assert system.broken_by(actions[name]) == {}

        @pytest.mark.parametrize(('name', 'guard'), guards)
        def test_each_guard_that_is_left_out_breaks_the_invariant_that_needs_it(
                self, name: str, guard: str) -> None:
            broken = system.broken_by(actions[name], without=guard)
            assert broken.get(needed_for[guard]) == 'sat', (
                f'without "{guard}" the action "{name}" breaks only {broken or "nothing"}')

    return Proof
