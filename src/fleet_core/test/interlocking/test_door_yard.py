"""Two robots and a door or a charger in a small yard, in any sequence of events: see `door_yard`.
"""
from __future__ import annotations

from typing import Any, Callable, Dict, FrozenSet, Iterator, NamedTuple, Type

import pytest
from door_yard import ChargerYard, Door, DoorFault, DoorYard, Request
from fleet_builders import AGV
from numbered_orders_model import Found
from proofs import LONG, is_whole
from test_yard import BEGINS, LINE, STAR
from yard_model import Bounds, Fault, State

from fleet_core.interlocking import interlocking
from fleet_core.interlocking.claims import Claims
from fleet_core.interlocking.interlocking import Interlocking
from fleet_core.interlocking.route_master import RouteMaster
from trajectory_graph import Graph

WHOLE = is_whole(__file__)
NEAREST = 400_000 if LONG else 60_000 if WHOLE else 5_000
"""Number of states that a search visits."""
WALKS = 2000 if LONG else 200 if WHOLE else 8
FAULTS: FrozenSet[Any] = frozenset({Fault.RESTART, Fault.DISK, *DoorFault})
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
    'a slow disk': Search(LINE, 2, frozenset({DoorFault.SLOW})),
}


@pytest.mark.parametrize('name', SEARCHES)
def test_no_door_closes_on_a_robot_whatever_happens(name: str, capsys: Any) -> None:
    found = SEARCHES[name].of()
    with capsys.disabled():
        print(f'\n{name}: {found.states} states')
    assert not found.flaw, str(found)


CHARGERS = {
    'a restart of the fleet manager': Search(STAR, 2, frozenset({Fault.RESTART})),
    'one robot after the other': Search(STAR, 3),
    'a full disk': Search(STAR, 2, frozenset({Fault.DISK})),
}


@pytest.mark.parametrize('name', list(CHARGERS)[:None if WHOLE or LONG else 1])
def test_no_two_robots_are_in_a_charger_for_one_whatever_happens(name: str, capsys: Any) -> None:
    found = CHARGERS[name].of(ChargerYard)
    with capsys.disabled():
        print(f'\na charger, {name}: {found.states} states')
    assert not found.flaw, str(found)


def walks(kind: Type[DoorYard] = DoorYard, most: int = WALKS, first: int = 0) -> Iterator[Found]:
    """The results of random walks, beginning with walk number `first`."""
    walked = yard(STAR, kind)
    return (walked.walk(WIDE, (first + k) % most, 200) for k in range(most))


@pytest.mark.parametrize('kind', (DoorYard, ChargerYard))
def test_nothing_goes_wrong_with_a_door_or_a_charger_in_a_random_walk(kind: Type[DoorYard]
                                                                      ) -> None:
    most = WALKS if kind is DoorYard else WALKS // 4
    for seed, found in enumerate(walks(kind, most)):
        assert not found.flaw, f'walk {seed}: {found}'


class TellsWhoIsInTheDoor(DoorYard):
    def flaw(self, state: State) -> str:
        for name, id in zip(self.names, state[1:]):
            edge = self._sides[id].vehicle.edge
            if edge is not None and abs(edge.label) in self.edges:
                return f'{name} is in the door'
        return super().flaw(state)


class TellsWhoHasLeftTheCharger(ChargerYard):
    def flaw(self, state: State) -> str:
        door: Door = self._sites[state[0]].door
        vehicle = self._sides[state[2]].vehicle
        if 'b' not in door.stored and vehicle.place not in self.places and vehicle.edge is None:
            return 'b has left the charger, and does not claim it'
        return super().flaw(state)


def test_a_robot_gives_the_charger_back_when_it_has_left_it() -> None:
    found = Search(LINE, 2).of(TellsWhoHasLeftTheCharger)
    assert found.flaw == 'b has left the charger, and does not claim it', str(found)


def test_a_robot_gets_through_the_door() -> None:
    found = Search(LINE, 2).of(TellsWhoIsInTheDoor)
    assert found.flaw.endswith('is in the door'), str(found)


# -- planted faults --------------------------------------------------------------------------------

FAR = 60
"""Maximum number of walks that may be needed to find a planted fault."""


class ForgetsClaimsAtARestart(DoorYard):
    def _restarted_claims(self, door: Door) -> Door:
        return super()._restarted_claims(door._replace(stored=frozenset()))


class TellsADoorNothingOfRobotsThatHaveClaims(DoorYard):
    def _restarted_claims(self, door: Door) -> Door:
        anew = super()._restarted_claims(door)
        return anew._replace(begun=True, request=Request(anew.number))


class ForgetsClaimsToTheChargerAtARestart(ChargerYard):
    def _restarted_claims(self, door: Door) -> Door:
        return super()._restarted_claims(door._replace(stored=frozenset()))


YARDS: Dict[Type[DoorYard], int] = {
    ForgetsClaimsAtARestart: 1, TellsADoorNothingOfRobotsThatHaveClaims: 57,
    ForgetsClaimsToTheChargerAtARestart: 0}
"""For each fault, the number of the walk that found it. This walk is tried first.

After a change of the model, another walk may find the fault first.
"""


@pytest.mark.parametrize('kind', YARDS)
def test_a_restart_with_a_planted_fault_is_found(kind: Type[DoorYard]) -> None:
    assert any(found.flaw for found in walks(kind, FAR, YARDS[kind]))


def without_the_guards(patch: pytest.MonkeyPatch) -> None:
    """Leaves out the checks of claims at a grant and at an order. Each of the two checks alone is
    enough, see `test_gates`.
    """
    patch.setattr(interlocking, 'CONDITIONS', interlocking.WITHOUT_CLAIMS)
    patch.setattr(Interlocking, '_kept_out', lambda *_, may_leave: None)


def more_than_there_is(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_is_free', lambda *_: True)


def ends_while_a_place_needs_it(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_kept', lambda claims, name: claims._wanted.get(name, frozenset()))


def counts_any_answer(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Claims, '_is_ready', lambda claims, name, resource: (
        resource in claims.stored_of(name) and resource in claims.open_for))


PLANTED = (without_the_guards, more_than_there_is, ends_while_a_place_needs_it, counts_any_answer)


@pytest.mark.parametrize('plant, kind', [
    *((plant, DoorYard) for plant in PLANTED),
    *((plant, ChargerYard) for plant in PLANTED if plant is not counts_any_answer)])
def test_a_planted_fault_of_claims_is_found(plant: Callable[[pytest.MonkeyPatch], None],
                                            kind: Type[DoorYard],
                                            monkeypatch: pytest.MonkeyPatch) -> None:
    plant(monkeypatch)
    assert any(found.flaw for found in walks(kind, FAR))


@pytest.mark.parametrize('name', ('a slow disk', 'a restart of the fleet manager'))
def test_an_order_that_is_sent_by_old_reports_is_found(
        name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Interlocking, '_kept_out', lambda *_, may_leave: None)
    found = SEARCHES[name].of()
    assert found.flaw.startswith('ENTERED'), str(found)


def test_a_grant_that_waits_for_a_full_disk_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two guards must be left out: the withdrawal of the grant, and the check of each order when it
    is sent.
    """
    monkeypatch.setattr(Interlocking, '_kept_out', lambda *_, may_leave: None)
    monkeypatch.setattr(RouteMaster, 'not_stored', lambda master: None)
    found = SEARCHES['a full disk'].of()
    assert found.flaw.startswith('ENTERED'), str(found)
