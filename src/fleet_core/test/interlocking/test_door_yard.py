"""Two robots and a door in a small yard, in every order of events: see `door_yard`."""
from __future__ import annotations

from typing import Any, Callable, FrozenSet, Iterator, NamedTuple, Tuple, Type

import pytest
from door_yard import Door, DoorFault, DoorYard, Request
from fleet_builders import AGV
from numbered_orders_model import Found
from proofs import LONG, is_whole
from test_yard import BEGINS, LINE, STAR
from yard_model import Bounds, Fault, State

from fleet_core.interlocking import interlocking
from fleet_core.interlocking.claims import Claims
from trajectory_graph import Graph

WHOLE = is_whole(__file__)
NEAREST = 400_000 if LONG else 60_000 if WHOLE else 5_000
"""Number of states that a search visits."""
WALKS = 2000 if LONG else 200 if WHOLE else 20
FAULTS: FrozenSet[Any] = frozenset({Fault.RESTART, Fault.DISK, DoorFault.RESTART})
WIDE = Bounds(grants=40, faults=12, acts=0, of=FAULTS)


def yard(graph: Graph, kind: Type[DoorYard] = DoorYard) -> DoorYard:
    return kind(graph, AGV, dict(list(BEGINS.items())[:2]))


class Search(NamedTuple):
    """A yard and bounds."""

    graph: Graph
    grants: int
    faults: FrozenSet[Any] = frozenset()

    def of(self, kind: Type[DoorYard] = DoorYard) -> Found:
        bounds = Bounds(self.grants, bool(self.faults), 0, False, self.faults)
        return yard(self.graph, kind).search(bounds, NEAREST)


SEARCHES = {
    'one robot after the other': Search(STAR, 3),
    'a restart of the fleet manager': Search(LINE, 2, frozenset({Fault.RESTART})),
    'a restart of the door': Search(LINE, 2, frozenset({DoorFault.RESTART})),
    'a full disk': Search(LINE, 2, frozenset({Fault.DISK})),
}


@pytest.mark.parametrize('name', SEARCHES)
def test_no_door_closes_on_a_robot_whatever_happens(name: str, capsys: Any) -> None:
    found = SEARCHES[name].of()
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


def walks(kind: Type[DoorYard] = DoorYard, most: int = WALKS) -> Iterator[Found]:
    walked = yard(STAR, kind)
    return (walked.walk(WIDE, seed, 200) for seed in range(most))


def test_no_door_closes_on_a_robot_in_a_random_walk() -> None:
    for seed, found in enumerate(walks()):
        assert not found.flaw, f'walk {seed}: {found}'


class TellsWhoIsInTheDoor(DoorYard):
    def flaw(self, state: State) -> str:
        for name, id in zip(self.names, state[1:]):
            edge = self._sides[id].vehicle.edge
            if edge is not None and abs(edge.label) in self.edges:
                return f'{name} is in the door'
        return super().flaw(state)


def test_a_robot_gets_through_the_door() -> None:
    found = Search(LINE, 2).of(TellsWhoIsInTheDoor)
    assert found.flaw.endswith('is in the door'), str(found)


# -- planted faults --------------------------------------------------------------------------------

FAR = 60
"""Number of walks within which a planted fault must be found."""


class ForgetsClaimsAtARestart(DoorYard):
    def _restarted_claims(self, door: Door) -> Door:
        return super()._restarted_claims(door._replace(stored=frozenset()))


class TellsADoorNothingOfRobotsThatHaveClaims(DoorYard):
    def _restarted_claims(self, door: Door) -> Door:
        anew = super()._restarted_claims(door)
        return anew._replace(begun=True, request=Request(anew.number))


YARDS: Tuple[Type[DoorYard], ...] = (
    ForgetsClaimsAtARestart, TellsADoorNothingOfRobotsThatHaveClaims)


@pytest.mark.parametrize('kind', YARDS)
def test_a_restart_with_a_planted_fault_is_found(kind: Type[DoorYard]) -> None:
    assert any(found.flaw for found in walks(kind, FAR))


def without_the_guard(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(interlocking, 'CONDITIONS', interlocking.WITHOUT_CLAIMS)


def more_than_there_is(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_is_free', lambda *_: True)


def ends_while_a_place_needs_it(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_kept', lambda claims, name: claims._wanted.get(name, frozenset()))


def counts_any_answer(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_is_ready', lambda claims, name, resource: (
        resource in claims.stored_of(name) and resource in claims.open_for))


PLANTED = (without_the_guard, more_than_there_is, ends_while_a_place_needs_it, counts_any_answer)


@pytest.mark.parametrize('plant', PLANTED)
def test_a_planted_fault_of_claims_is_found(plant: Callable[[pytest.MonkeyPatch], None],
                                            monkeypatch: pytest.MonkeyPatch) -> None:
    plant(monkeypatch)
    assert any(found.flaw for found in walks(most=FAR))
