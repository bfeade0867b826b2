"""Requests with stops survive the conversion to messages and back; wrong requests are refused."""
from __future__ import annotations

import pytest
from genpy import Time

from fleet_core.supervision.missions import MissionState, RequestRefused, Status, StepAnswer
from fleet_core.work.dependencies import Dependency, Until
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    StopKind,
    When,
    WorkStep,
    WorkStop,
)
from graph_fleet_manager.messages.missions import request_of, status_message
from graph_fleet_manager.messages.stops import (
    WrongStopMessage,
    answer_of,
    stop_messages,
    stops_of,
)
from itrci_nav_msgs import msg

STOPS = tuple(
    WorkStop(place, kind, (WorkStep('say', 5.0, (('text', 'hello'),), when, actor, blocking, policy,
                                    2, True, True, effect, load_type='pallet'),
                           WorkStep('wait', 1.0)), condition)
    for place, (kind, when, actor, blocking, policy, effect, condition) in enumerate(zip(
        StopKind, [*When] * 2, Actor, [*StepBlocking] * 2, Policy, [*LoadEffect] * 2,
        [*Condition] * 2)))


def test_stops_come_back():
    assert stops_of(stop_messages(STOPS)) == STOPS


def test_a_stop_at_a_group_has_no_vertex_yet():
    stops = (WorkStop(0, group='shelves'),)
    assert stops_of(stop_messages(stops)) == stops
    chosen = (WorkStop(42, group='shelves'),)
    assert stops_of(stop_messages(chosen)) == stops
    with pytest.raises(WrongStopMessage, match='vertex 42 and also a group'):
        stops_of([msg.MissionStop(vertex=42, group='shelves')])


def test_the_constants_of_the_messages_are_those_of_the_values():
    for enum, message in ((When, msg.MissionStep), (Actor, msg.MissionStep),
                          (StepBlocking, msg.MissionStep), (Policy, msg.MissionStep),
                          (StopKind, msg.MissionStop), (Condition, msg.MissionStop)):
        for one in enum:
            assert getattr(message, one.name) == int(one), one
    effects = [msg.MissionStep.NO_LOAD, msg.MissionStep.TAKES, msg.MissionStep.GIVES]
    assert [int(one) for one in LoadEffect] == effects
    for decision in StepDecision:
        if decision:
            assert getattr(msg.MissionCommand, decision.name) == int(decision)
    for state in MissionState:
        assert getattr(msg.MissionStatus, state.name) == int(state)


def test_a_request_with_stops_has_their_vertices_as_destinations():
    request = request_of(msg.MissionRequest(
        request_id=1, stops=stop_messages((WorkStop(3), WorkStop(5, steps=(WorkStep('a', 1.0),)),
                                           WorkStop(6))),
        on_cancel=stop_messages((WorkStop(9),))))
    assert request.destinations == (3, 5, 6) and request.dwells == (0.0, -1.0, -1.0)
    assert [stop.place for stop in request.on_cancel] == [9]


def test_a_request_without_stops_means_what_it_meant():
    request = request_of(msg.MissionRequest(
        request_id=1, destination_vertices_id=[3, 5], dwell=[1.0, 0.0]))
    assert (request.destinations, request.dwells) == ((3, 5), (1.0, 0.0))
    assert request.stops == request.on_cancel == ()


@pytest.mark.parametrize('more', [{'destination_vertices_id': [1]}, {'dwell': [1.0]}])
def test_a_request_has_stops_or_destinations(more):
    with pytest.raises(RequestRefused, match='give one of them'):
        request_of(msg.MissionRequest(stops=stop_messages((WorkStop(3),)), **more))


@pytest.mark.parametrize('stop', [
    msg.MissionStop(kind=9), msg.MissionStop(condition=9),
    msg.MissionStop(steps=[msg.MissionStep(actor=9)])])
def test_a_stop_with_an_unknown_number_is_refused(stop):
    with pytest.raises(RequestRefused, match='does not exist'):
        request_of(msg.MissionRequest(stops=[stop]))


def test_a_request_names_the_missions_that_must_end_first():
    request = request_of(msg.MissionRequest(destination_vertices_id=[3], after=[
        msg.MissionDependency(4, msg.MissionDependency.DONE),
        msg.MissionDependency(5, msg.MissionDependency.ENDED)]))
    assert request.after == (Dependency(4, Until.DONE), Dependency(5, Until.ENDED))
    with pytest.raises(RequestRefused, match='does not exist'):
        request_of(msg.MissionRequest(after=[msg.MissionDependency(4, 9)]))


def test_an_answer_names_its_step():
    message = msg.MissionCommand(answer=msg.MissionCommand.SKIP, step_key=2 ** 60)
    assert answer_of(message) == StepAnswer(StepDecision.SKIP, 2 ** 60)
    for wrong in (0, 9):
        with pytest.raises(WrongStopMessage, match=f'answer is {wrong}'):
            answer_of(msg.MissionCommand(answer=wrong))


def test_a_status_names_the_step_that_asks():
    status = Status(1, MissionState.NEEDS_PERSON, asks=2 ** 60)
    assert status_message(status, Time(1)).asks == 2 ** 60
