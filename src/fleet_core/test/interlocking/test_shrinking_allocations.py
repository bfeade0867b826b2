"""An allocation that only shrinks excludes no further robot, so it is not compared again."""
from __future__ import annotations

from dataclasses import replace
from typing import Set

from fleet_builders import AGV, corridor
from hypothesis import given
from hypothesis import strategies as st

from fleet_core.geometry.areas import Area
from fleet_core.geometry.site_geometry import SiteGeometry
from fleet_core.interlocking.allocation import Allocation, Hold, Knowledge
from fleet_core.interlocking.held_places import HeldPlaces

GEOMETRY = SiteGeometry(corridor(5, siding_at=3))
HOLDS = st.lists(st.builds(Hold, st.sampled_from([
    sign * edge for edge in GEOMETRY.edge_ids for sign in (1, -1)]), st.floats(0.0, 0.9)),
    max_size=3)
AREAS = st.lists(st.sampled_from([Area(((x, 0.0),), 0.5) for x in (0.0, 2.0)]), max_size=2)
WIDE = replace(AGV, radius=2 * AGV.radius)  # with a load
ALLOCATIONS = st.builds(
    lambda kind, holds, vertex, areas: Allocation(kind, Knowledge.KNOWN, tuple(holds), vertex,
                                                  tuple(areas)),
    st.sampled_from((AGV, WIDE)), HOLDS, st.sampled_from((None, *GEOMETRY.vertex_ids)), AREAS)


def excluding(allocation: Allocation, held: HeldPlaces) -> Set[str]:
    held.put('own', allocation)
    return {name for place in held.places('own')
            for name in held.excluding('own', allocation.kind, place)}


@given(ALLOCATIONS, ALLOCATIONS, ALLOCATIONS, ALLOCATIONS)
def test_an_allocation_within_another_excludes_no_further_robot(
        one: Allocation, whole: Allocation, a: Allocation, b: Allocation) -> None:
    held = HeldPlaces(GEOMETRY, 0.1)
    held.put('a', a)
    held.put('b', b)
    if one.is_within(whole):
        assert set(one.areas) <= set(whole.areas)
        assert excluding(one, held) <= excluding(whole, held)


@given(ALLOCATIONS, st.data())
def test_what_a_robot_leaves_makes_its_allocation_smaller(whole: Allocation,
                                                         data: st.DataObject) -> None:
    left = data.draw(st.integers(0, len(whole.holds)))
    holds = tuple(hold._replace(cleared=max(hold.cleared, data.draw(st.floats(0.0, 0.9))))
                  for hold in whole.holds[left:])
    smaller = Allocation(whole.kind, Knowledge.KNOWN, holds, None, whole.areas[1:])
    assert whole.is_within(whole)
    assert smaller.is_within(whole)
    held = HeldPlaces(GEOMETRY, 0.1)
    held.put('a', data.draw(ALLOCATIONS))
    assert excluding(smaller, held) <= excluding(whole, held)


def test_a_robot_of_which_less_is_known_is_compared_again() -> None:
    known, unknown = (Allocation(AGV, knowledge, vertex=1)
                      for knowledge in (Knowledge.KNOWN, Knowledge.UNKNOWN))
    assert not unknown.is_within(known) and not known.is_within(unknown)


def test_a_robot_whose_load_makes_it_wider_is_compared_again() -> None:
    empty, laden = (Allocation(kind, Knowledge.KNOWN, vertex=1) for kind in (AGV, WIDE))
    assert empty.is_within(laden) and not laden.is_within(empty)
