"""Results of requests (accepted, refused, repeated), and reasons about robots."""
from __future__ import annotations

import pytest
from fleet_builders import AGV, corridor

from fleet_core.supervision import mission_book
from fleet_core.supervision.mission_book import REMEMBERED, MissionBook
from fleet_core.supervision.missions import (
    Acceptance,
    MissionState,
    Request,
    RequestRefused,
)
from fleet_core.supervision.outages import TRANSITIONS, Outage, Sign, sign_of
from route_protocol.values import Reason, ReasonCode

ACCEPTANCE = Acceptance(corridor(5), {'a': AGV, 'b': AGV})


@pytest.mark.parametrize('request_, reason', [
    (Request(1, ()), 'no destinations'),
    (Request(1, (99,)), 'the graph has no vertex 99'),
    (Request(1, (2,) * 1001), 'more than 1000 destinations'),
    (Request(1, (2,), robot_type='truck'), "no robot of type 'truck'; there are: agv"),
    (Request(1, (2,), robot='c'), "no robot 'c'; there are: a, b"),
    (Request(1, (2,), robot_type='agv', robot='c'), "no robot 'c'"),
    (Request(1, (2, 3), dwells=(1.0,)), '2 destinations but 1 dwells'),
    (Request(1, (2,), dwells=(float('nan'),)), 'must be a number'),
    (Request(1, (2,), dwells=(1e9,)), 'must be a number')])
def test_what_nobody_can_do_is_refused_with_the_reason(request_, reason):
    with pytest.raises(RequestRefused, match=reason):
        MissionBook().add(request_, ACCEPTANCE)


@pytest.mark.parametrize('stamp', [0.0, 5.0])
def test_a_repeat_of_an_open_mission_changes_nothing(stamp):
    book = MissionBook()
    assert book.add(Request(1, (2,), stamp=stamp), ACCEPTANCE) is not None
    assert book.add(Request(1, (2,), stamp=stamp), ACCEPTANCE) is None
    assert len(book.open) == 1


def test_so_many_missions_are_open_and_no_more(monkeypatch):
    monkeypatch.setattr(mission_book, 'MOST_OPEN', 2)
    book = MissionBook()
    first = book.add(Request(1, (2,)), ACCEPTANCE)
    book.add(Request(2, (2,)), ACCEPTANCE)
    with pytest.raises(RequestRefused, match='2 missions are open'):
        book.add(Request(3, (2,)), ACCEPTANCE)
    assert book.add(Request(2, (2,)), ACCEPTANCE) is None
    book.set(first, MissionState.CANCELLED)
    book.stored()
    assert book.add(Request(3, (2,)), ACCEPTANCE) is not None


def test_the_id_of_an_open_mission_with_other_content_is_refused():
    book = MissionBook()
    book.add(Request(1, (2,)), ACCEPTANCE)
    with pytest.raises(RequestRefused, match='open with other content'):
        book.add(Request(1, (3,)), ACCEPTANCE)
    with pytest.raises(RequestRefused, match='open with other content'):
        book.add(Request(1, (2,), stamp=5.0), ACCEPTANCE)


def test_an_ended_id_may_be_used_anew_but_its_late_repeat_is_no_new_mission():
    book = MissionBook()
    mission = book.add(Request(1, (2,), stamp=5.0), ACCEPTANCE)
    book.set(mission, MissionState.CANCELLED)
    book.stored()
    assert book.add(Request(1, (2,), stamp=5.0), ACCEPTANCE) is None
    assert book.add(Request(1, (2,), stamp=6.0), ACCEPTANCE) is not None


def test_an_ended_mission_stays_as_it_ended():
    book = MissionBook()
    mission = book.add(Request(1, (2,)), ACCEPTANCE)
    book.reach(mission)
    book.set(mission, MissionState.CANCELLED)
    assert mission.state is MissionState.SUCCEEDED


def test_driving_through_counts_as_a_visit_but_not_where_it_is_to_stay():
    book = MissionBook()
    through = book.add(Request(1, (2, 3, 3, 5)), ACCEPTANCE)
    assert through.visits((2, 3, 4)) == 3
    staying = book.add(Request(2, (2, 3, 5), dwells=(0.0, 4.0, 0.0)), ACCEPTANCE)
    assert staying.visits((2, 3, 4, 5)) == 1


@pytest.mark.parametrize('code, outage', [
    (ReasonCode.EMERGENCY_STOP, Outage.STOPPED), (ReasonCode.TAKEN_OVER, Outage.TAKEN_OVER),
    (ReasonCode.LOST_LINK, Outage.LOST_LINK), (ReasonCode.OFF_GRAPH, Outage.FAILED),
    (ReasonCode.CLOCK, Outage.CLOCK), (ReasonCode.OTHER, Outage.FAILED)])
def test_the_code_of_a_failed_route_and_no_word_says_how_the_robot_comes_back(code, outage):
    reason = Reason(code, 'emergency stop, taken over, lost link')
    assert TRANSITIONS[sign_of(reason)].target is outage
    assert outage.needs_person == (outage in (Outage.TAKEN_OVER, Outage.FAILED))


_OF_PEOPLE = {Sign.TAKEN_OUT, Sign.BROUGHT_IN, Sign.DECLARED_ABSENT}


@pytest.mark.parametrize('outage', Outage)
def test_each_outage_begins_and_ends_by_an_event_and_its_end_is_told(outage):
    """No outage needs a restart to end. An outage that needs a person ends with `fleet in`."""
    ends = {sign for sign, change in TRANSITIONS.items()
            if outage in change.sources and change.target is None}
    begins = {sign for sign, change in TRANSITIONS.items() if change.target is outage}
    assert begins or outage is Outage.UNSEEN  # each robot begins with UNSEEN
    assert Sign.BROUGHT_IN in ends or outage is Outage.ABSENT
    by_itself = ends - _OF_PEOPLE
    assert bool(by_itself) is not outage.needs_person or outage is Outage.OFF_GRAPH
    assert ('`fleet in a`' in outage.way_back('a')) is outage.needs_person


def test_ended_missions_are_forgotten_but_for_the_last():
    book = MissionBook()
    for id in range(1, REMEMBERED + 12):
        book.set(book.add(Request(id, (2,)), ACCEPTANCE), MissionState.CANCELLED)
        book.stored()
    book.add(Request(3, (2,)), ACCEPTANCE)  # an id that is used again
    assert book.find(2) is None and book.find(3).state is MissionState.PENDING
    assert book.find(REMEMBERED + 11).state is MissionState.CANCELLED
    assert len(book._last) == REMEMBERED + 1
