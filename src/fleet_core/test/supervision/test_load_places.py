"""Places that are too near to a stop with a load are found before the work begins."""
from __future__ import annotations

from dataclasses import replace
from typing import Dict, Mapping, Tuple

import pytest
from fleet_builders import AGV, graph_of, with_docks

from fleet_core.fleet import Fleet
from fleet_core.geometry.exclusions import ROUNDING
from fleet_core.supervision.load_places import TooNear, too_near
from fleet_core.work.loads import LoadType
from fleet_core.work.site_work import JobSteps, SiteWork
from fleet_core.work.stations import Station, StationKind
from fleet_core.work.stops import Condition, LoadEffect, StopKind, WorkStep
from fleet_core.work.templates import Template, TemplateStop
from fleet_core.work.timetables import Timetable

PALLET = LoadType('pallet', 0.8)
FLEET = Fleet((AGV,), (), 0.1)
APART = 0.4 + 0.8 + 0.1  # m between a robot without a load and a robot with a pallet
PRESS, PACKING = Station('press', (1,), (2,)), Station('packing', (3,))
TAKE = WorkStep('take', 60.0, load=LoadEffect.TAKES, load_type='pallet')
GIVE = WorkStep('give', 60.0, load=LoadEffect.GIVES)


def carry(at: str, to: str) -> Template:
    names = tuple(word[1:] for word in (at, to) if word.startswith('$'))
    return Template('carry', names, (TemplateStop(at, StopKind.PICKUP, (TAKE,)),
                                     TemplateStop(to, StopKind.DROPOFF, (GIVE,))))


def site(template: Template, *stations: Station, loads: Tuple[LoadType, ...] = (PALLET,),
         **more: object) -> SiteWork:
    return SiteWork({one.name: one for one in stations or (PRESS, PACKING)},
                    templates={template.name: template},
                    loads={one.name: one for one in loads}, **more)


def found(work: SiteWork, places: Mapping[int, float], docks: Tuple[int, ...] = (),
          fleet: Fleet = FLEET) -> Dict[Tuple[int, int], TooNear]:
    """Returns the pairs of places that are too near to each other; the key is the two vertices.

    places -- x (m) of each vertex; all vertices are on one line
    """
    ids = list(places)
    graph = with_docks(graph_of({id: (x, 0.0) for id, x in places.items()},
                                dict(enumerate(zip(ids, ids[1:]), 1))), *docks)
    return {(one.other, one.place): one for one in too_near(work, fleet, graph)}


def at(distance: float) -> Mapping[int, float]:
    """The x (m) of the press, of its queue place, and of the packing table far away."""
    return {1: 0.0, 2: distance, 3: 50.0}


def test_a_queue_place_nearer_than_a_load_allows_is_told_in_one_sentence():
    one, = found(site(carry('press', 'packing')), at(1.2)).values()
    assert one.text == (
        'queue place 2 of station press is 1.20 m from vertex 1, but robots need 1.30 m there '
        'with load pallet: while a robot stands at 2, no other one takes or brings such a load at '
        '1; put the two farther apart')


def test_places_exactly_as_far_apart_as_the_interlocking_asks_are_not_too_near():
    work = site(carry('press', 'packing'))
    assert found(work, at(APART)) == {}
    assert found(work, at(APART - 10.0 * ROUNDING)).keys() == {(2, 1)}


def test_a_robot_that_waits_to_bring_a_load_has_it_already():
    assert found(site(carry('packing', 'press')), at(1.5)).keys() == {(2, 1)}


def test_two_queue_places_nearer_than_robots_with_loads_need_are_told_once():
    line = {1: 0.0, 2: 5.0, 4: 6.5, 3: 50.0}
    press = replace(PRESS, queue=(2, 4))
    one, = found(site(carry('packing', 'press'), press, PACKING), line).values()
    assert one.text == (
        'queue place 4 of station press is 1.50 m from vertex 2, but robots need 1.70 m there '
        'with load pallet: while a robot stands at 4, no other one waits with such a load at 2; '
        'put the two farther apart')
    assert found(site(carry('press', 'packing'), press, PACKING), line) == {}
    assert found(site(carry('packing', 'press'), press, PACKING), {**line, 4: 6.7}) == {}


def test_a_queue_place_beside_that_of_another_station_is_told_if_robots_wait_there_with_a_load():
    line = {1: 0.0, 2: 5.0, 5: 6.2, 3: 50.0}
    work = site(carry('packing', 'press'), PRESS, replace(PACKING, queue=(5,)))
    assert found(work, line).keys() == {(5, 2)}
    assert found(work, {**line, 5: 6.4}) == {}


def test_a_dock_beside_the_place_of_a_load_is_told_if_a_robot_may_stand_there():
    work = site(carry('press', 'packing'), Station('press', (1,)), PACKING)
    assert found(work, at(1.2), docks=(2,))[2, 1].what == 'dock 2'
    others = replace(FLEET, types=(replace(AGV, docks=frozenset({7})),))
    assert found(work, at(0.6), docks=(2,), fleet=others) == {}


def test_a_place_of_another_station_or_of_a_group_is_told_once():
    shelves = Station('shelves', (1, 2), (), 2, StationKind.GROUP)
    work = site(carry('shelves', 'packing'), shelves, PACKING)
    assert found(work, at(1.2)).keys() == {(2, 1)}
    one_robot = site(carry('shelves', 'packing'), replace(shelves, capacity=1), PACKING)
    assert found(one_robot, at(1.2)) == {}
    neighbour = site(carry('press', 'packing'), Station('press', (1,)), PACKING,
                     Station('scale', (2,)))
    assert found(neighbour, at(1.2)).keys() == {(2, 1)}


def test_a_load_that_needs_no_more_room_keeps_nobody_away():
    for load in (LoadType('pallet', 0.4), LoadType('pallet', speed=0.3)):
        assert found(site(carry('press', 'packing'), loads=(load,)), at(0.5)) == {}


def test_a_load_is_carried_until_it_is_given():
    template = Template('carry', (), (
        TemplateStop('press', steps=(TAKE,)), TemplateStop('press', steps=(TAKE,)),
        TemplateStop('packing', steps=(GIVE,)), TemplateStop('scale', steps=(GIVE,)),
        TemplateStop('9')))
    scale = Station('scale', (5,), (6,))
    far = {1: 0.0, 2: 9.0, 3: 20.0, 5: 40.0, 6: 41.2, 9: 60.0, 10: 61.2}
    work = site(template, PRESS, PACKING, scale, Station('door', (11,), (10,)))
    assert found(work, {**far, 11: 80.0}).keys() == {(6, 5)}, 'and at 9 it carries nothing'


def test_the_stops_after_a_cancellation_are_those_of_a_robot_with_its_load():
    for condition, told in ((Condition.LOADED, {(2, 1)}), (Condition.EMPTY, set())):
        template = replace(carry('packing', '4'), on_cancel=(
            TemplateStop('press', steps=(GIVE,), condition=condition),))
        assert found(site(template), {**at(1.5), 4: 90.0}).keys() == told


def test_a_parameter_stands_for_each_station_and_for_what_timetables_give():
    assert found(site(carry('$from', 'packing')), at(1.2)).keys() == {(2, 1)}
    table = Timetable('hourly', 'carry', 60, (('from', '4'),))
    work = site(carry('$from', 'packing'), timetables={'hourly': table})
    assert found(work, {**at(9.0), 4: 10.2}).keys() == {(2, 4)}


def test_the_steps_of_jobs_carry_loads_as_templates_do():
    jobs = (JobSteps(StopKind.PICKUP, (TAKE,), (3,)), JobSteps(StopKind.DROPOFF, (GIVE,)))
    work = replace(site(carry('press', 'packing')), templates={}, job_steps=jobs)
    assert found(work, at(1.5)).keys() == {(2, 1)}
    assert found(replace(work, job_steps=jobs[:1]), at(1.5)) == {}


def test_of_several_types_of_robots_and_loads_the_widest_counts():
    box = LoadType('box', 1.0)
    both = replace(carry('press', 'packing'), stops=(
        TemplateStop('press', steps=(TAKE, replace(TAKE, load_type='box'))),))
    one, = found(site(both, loads=(PALLET, box)), at(1.6), fleet=replace(
        FLEET, types=(AGV, replace(AGV, name='large', radius=0.6)))).values()
    assert one.needed == pytest.approx(1.0 + 0.6 + 0.1)
    assert one.loads == frozenset({'pallet', 'box'})
