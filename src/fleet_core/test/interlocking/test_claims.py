"""The claims of robots to resources: their states, and the claims that a robot gets."""
from __future__ import annotations

import re
from itertools import product
from typing import Dict, Iterator, Tuple

import pytest
from fleet_builders import AGV, corridor

from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking import claims as module
from fleet_core.interlocking.allocation import Allocation, Hold, Knowledge
from fleet_core.interlocking.claims import Claims, ClaimState, Facts
from fleet_core.interlocking.resources import Needs, Resource, ResourceKind
from fleet_core.interlocking.route_master import ME
from route_protocol.devices import DeviceMode, DeviceRequest

GRAPH = SiteGeometry(corridor(10))


def resource(name: str, *edges: int, vertices: Tuple[int, ...] = (), capacity: int = 1,
             device: bool = False) -> Resource:
    return Resource(name, ResourceKind.DOOR, frozenset(edges), frozenset(vertices), capacity,
                    device)


def claims_to(*resources: Resource, **stored: Tuple[str, ...]) -> Claims:
    return Claims(Needs(resources, GRAPH), {name: frozenset(own) for name, own in stored.items()})


def on(*edges: int) -> Allocation:
    return Allocation(AGV, Knowledge.KNOWN, tuple(map(Hold, edges)))


def at(vertex: int) -> Allocation:
    return Allocation(AGV, Knowledge.KNOWN, vertex=vertex)


# -- the table of states ---------------------------------------------------------------------------

CHANGES = {
    'it is ready': {'ready': True}, 'it is not ready, or silent': {'ready': False},
    'a place with it is allocated': {'needed': True},
    'no allocated place needs it': {'needed': False},
    'the robot asks for it': {'wanted': True},
    'the robot asks for other edges': {'wanted': False},
    'the fleet manager restarts': {'wanted': False},
}
CHOICES = {'by device': {ClaimState.IN_USE, ClaimState.LOST, ClaimState.READY, ClaimState.ASKED},
           'by wish': {ClaimState.READY, ClaimState.ASKED, ClaimState.RETURNING}}


def rows() -> Iterator[Tuple[str, Dict[str, str]]]:
    """Yields each event in the table of the module's docstring, with the word in each column."""
    table = re.findall(r'^    \| (.*) \|$', module.__doc__ or '', re.MULTILINE)
    lines = [[word.strip() for word in line.split('|')] for line in table]
    head = next(line for line in lines if line[0] == 'event')
    for event, *words in lines[lines.index(head) + 1:]:
        yield event, dict(zip(head[1:], words))


def test_the_docstring_tells_each_state_after_each_event() -> None:
    told = dict(rows())
    assert set(told) == {*CHANGES, 'the journal is written'}
    for event, change in CHANGES.items():
        for facts in map(Facts._make, product((False, True), repeat=3)):
            word, after = told[event][facts.state.name], facts._replace(**change).state
            assert after in CHOICES[word] if word in CHOICES else after.name == word, (event, facts)


def test_each_state_stays_when_the_journal_is_written_except_that_a_returned_claim_ends() -> None:
    claims = claims_to(resource('door', 5))
    claims.follow('a', at(1))
    claims.want('a', [4, 5])
    claims.stored()
    assert claims.state('a', 'door') is ClaimState.READY
    claims.follow('a', on(4, 5))
    claims.stored()
    assert claims.state('a', 'door') is ClaimState.IN_USE
    claims.follow('a', at(6))
    claims.want('a', ())
    assert claims.state('a', 'door') is ClaimState.RETURNING
    assert not claims.to_store['a'] and claims.holders('door') == ['a']
    claims.stored()
    assert claims.state('a', 'door') is None and not claims.is_changed


# -- what needs what -------------------------------------------------------------------------------

def test_an_edge_needs_what_the_vertices_at_its_ends_need() -> None:
    needs = Needs([resource('station', vertices=(5,)), resource('door', 7)], GRAPH)
    assert needs.of_edge(4) == needs.of_edge(-5) == {'station'} and not needs.of_edge(3)
    assert needs.of_edge(7) == {'door'} and not needs.of_vertex(7)


@pytest.mark.parametrize(('edge', 'cleared', 'needed'), [
    (5, 0.0, {'press'}), (5, 0.1, {'press'}), (5, 0.5, set()), (-4, 0.5, set()),
    (4, 0.5, {'press'}), (-5, 0.5, {'press'}), (6, 0.5, {'door'})])
def test_an_edge_does_not_need_what_only_the_vertex_behind_its_robot_needs(
        edge: int, cleared: float, needed: set) -> None:
    needs = Needs([resource('press', vertices=(5,)), resource('door', 6)], GRAPH)
    assert needs.of(Allocation(AGV, Knowledge.KNOWN, (Hold(edge, cleared),))) == needed


def test_who_leaves_a_resource_gets_into_nothing() -> None:
    needs = Needs([resource('station', vertices=(5,)), resource('door', 5)], GRAPH)
    assert needs.on_entry(5, is_inside=False) == {'door'}
    assert needs.on_entry(5, is_inside=True) == set()
    assert needs.on_entry(-5, is_inside=True) == {'station'}


@pytest.mark.parametrize(('area', 'needed'), [
    (Area(((9.0, 0.0),)), {'door'}), (Area(((7.5, 0.0),)), set()),
    (Area(((7.5, 0.0),), 1.0), {'door'}), (Area(((9.0, 3.0),), 1.0), set())])
def test_a_robot_that_may_be_in_an_area_needs_what_is_there(area: Area, needed: set) -> None:
    allocation = Allocation(AGV, Knowledge.KNOWN, areas=(area,))
    assert Needs([resource('door', 5)], GRAPH).of(allocation) == needed


@pytest.mark.parametrize(('x', 'needed'), [(7.7, {'press'}), (8.3, {'press'}), (7.5, set())])
def test_a_robot_that_covers_the_vertex_of_a_resource_with_its_body_needs_it(
        x: float, needed: set) -> None:
    allocation = Allocation(AGV, Knowledge.KNOWN, areas=(Area(((x, 0.0),)),))
    assert Needs([resource('press', vertices=(5,))], GRAPH).of(allocation) == needed


# -- who gets what ---------------------------------------------------------------------------------

@pytest.mark.parametrize('capacity', [1, 2, 3])
def test_claims_do_not_exceed_the_capacity(capacity: int) -> None:
    claims = claims_to(resource('zone', 5, capacity=capacity))
    for name in 'abcd':
        claims.want(name, [5])
        claims.stored()
    assert claims.holders('zone') == list('abcd')[:capacity]


def test_claims_of_edges_that_follow_each_other_are_had_together_or_not_at_all() -> None:
    claims = claims_to(resource('one', 3), resource('two', 4), resource('far', 7))
    claims.want('b', [4])
    claims.want('a', [2, 3, 4, 5, 6, 7])
    assert claims.of('a') == set()
    claims.want('b', ())
    claims.stored()
    claims.want('a', [2, 3, 4, 5, 6, 7])
    assert claims.of('a') == {'one', 'two', 'far'}


def test_a_robot_that_cannot_have_the_whole_chain_returns_its_beginning() -> None:
    claims = claims_to(resource('one', 3), resource('two', 4))
    claims.want('b', [4])
    claims.want('a', [3])
    claims.stored()
    claims.want('a', [3, 4])
    assert claims.state('a', 'one') is ClaimState.RETURNING
    assert claims.keeping_out('a', 3, is_inside=False) == 'one'


def test_where_evidence_says_that_a_robot_is_it_claims_more_than_there_is() -> None:
    claims = claims_to(resource('zone', 5), a=('zone',))
    claims.follow('a', on(5))
    claims.follow('b', on(5))
    assert claims.holders('zone') == ['a', 'b']
    assert claims.keeping_out('b', -5, is_inside=True) == 'zone', 'its claim is not stored yet'
    claims.stored()
    assert claims.keeping_out('b', -5, is_inside=True) == ''
    claims.want('c', [5])
    assert claims.holders('zone') == ['a', 'b']


def test_a_robot_that_may_be_anywhere_keeps_its_claims() -> None:
    claims = claims_to(resource('zone', 5), a=('zone',))
    claims.follow('a', Allocation(AGV, Knowledge.UNKNOWN))
    assert claims.state('a', 'zone') is ClaimState.IN_USE
    claims.follow('a', Allocation(AGV, Knowledge.ABSENT))
    assert claims.state('a', 'zone') is ClaimState.RETURNING


def test_a_robot_that_left_the_site_returns_its_claims() -> None:
    claims = claims_to(resource('zone', 5), a=('zone',))
    claims.follow('a', on(5))
    claims.forget('a')
    assert claims.to_store == {'a': set()}
    claims.stored()
    assert not claims.holders('zone')


def test_what_the_site_does_not_have_any_more_is_not_claimed() -> None:
    claims = claims_to(resource('door', 5), a=('gate', 'door'))
    assert claims.of('a') == {'door'} and not claims.holders('gate')


def test_a_claim_that_is_returned_before_it_was_stored_ends_at_once() -> None:
    claims = claims_to(resource('zone', 5))
    claims.want('a', [5])
    claims.want('a', ())
    assert not claims.holders('zone') and not claims.is_changed


# -- requests to devices ---------------------------------------------------------------------------

def test_a_device_is_asked_only_for_stored_claims_and_by_growing_numbers() -> None:
    claims = Claims(Needs([resource('door', 5, device=True)], GRAPH), {}, 40, lambda: 1000)
    assert not claims.requests and claims.is_changed, 'at the start each device is asked anew'
    claims.stored()
    first = claims.requests['door']
    assert first == DeviceRequest(ME, 'door', DeviceMode.CLOSED, claims.number)
    assert first.number >= 1000
    claims.want('a', [5])
    assert claims.requests['door'] is first and claims.number > first.number
    claims.stored()
    assert claims.requests['door'] == DeviceRequest(ME, 'door', DeviceMode.OPEN, claims.number)
    assert claims.asked_for('door') == {'a'}


def test_numbers_of_requests_grow_over_a_restart_though_the_clock_was_set_back() -> None:
    assert Claims(Needs([resource('door', 5, device=True)], GRAPH), {}, 40, lambda: 7).number == 41


def test_after_a_request_of_a_lost_journal_only_a_later_one_makes_a_device_ready() -> None:
    claims = claims_to(resource('door', 5, device=True))
    claims.want('a', [5])
    claims.stored()
    claims.outnumber(10 ** 6)
    claims.open_for = {'door': 10 ** 6}
    assert claims.is_changed and claims.state('a', 'door') is ClaimState.ASKED
    claims.stored()
    request = claims.requests['door']
    assert request.number > 10 ** 6 and request.mode is DeviceMode.OPEN
    assert claims.state('a', 'door') is ClaimState.ASKED
    claims.open_for = {'door': request.number}
    assert claims.state('a', 'door') is ClaimState.READY


def test_a_device_is_ready_for_a_robot_only_by_a_request_with_this_robot() -> None:
    claims = claims_to(resource('door', 5, device=True, capacity=2), a=('door',))
    claims.follow('a', on(5))
    claims.stored()
    first = claims.requests['door'].number
    claims.want('b', [5])
    claims.stored()
    claims.open_for = {'door': first}
    assert claims.state('a', 'door') is ClaimState.IN_USE
    assert claims.state('b', 'door') is ClaimState.ASKED
    claims.open_for = {'door': claims.requests['door'].number}
    assert claims.state('b', 'door') is ClaimState.READY
    claims.open_for = {}
    assert list(claims.lost()) == [('a', 'door')]


def test_a_claim_that_was_returned_and_had_again_needs_a_new_answer() -> None:
    claims = claims_to(resource('door', 5, device=True))
    claims.want('a', [5])
    claims.stored()
    claims.open_for = {'door': claims.requests['door'].number}
    claims.want('a', ())
    claims.stored()
    claims.want('a', [5])
    claims.stored()
    assert claims.state('a', 'door') is ClaimState.ASKED
