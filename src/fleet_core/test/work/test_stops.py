"""Stops and steps that cannot be carried out are refused; each refusal has a reason and a line."""
from __future__ import annotations

from dataclasses import replace

import pytest
from fleet_builders import AGV, corridor, with_docks

from fleet_core.files.errors import FileError
from fleet_core.files.stops_file import load_stops
from fleet_core.supervision.missions import Acceptance, Request, RequestRefused
from fleet_core.work import rules
from fleet_core.work.stops import (
    LONGEST_TIMEOUT,
    MOST_STEPS,
    MOST_STOPS,
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    StopKind,
    When,
    WorkStep,
    WorkStop,
    WrongStops,
    check_stops,
    dwells_of,
)
from fleet_core.work.tables import StopState
from fleet_core.work.work import RobotLoad, Situation, work_of

STEP = WorkStep('engage', 60.0)


@pytest.mark.parametrize('changes, told', [
    ({'type': ''}, 'needs a type'),
    ({'type': 'a\n'}, 'cannot be printed'),
    ({'parameters': (('a', '1'), ('a', '2'))}, 'two parameters with one name'),
    ({'parameters': tuple((str(k), '') for k in range(21))}, 'more than 20 parameters'),
    ({'timeout': 0.0}, 'needs a timeout'), ({'timeout': float('nan')}, 'needs a timeout'),
    ({'timeout': LONGEST_TIMEOUT * 2}, 'needs a timeout'),
    ({'actor': Actor.DEVICE}, 'needs the name of a device'),
    ({'device': 'press'}, 'needs the name of a device'),
    ({'actor': Actor.DEVICE, 'device': 'press'}, 'its type must be handshake'),
    ({'actor': Actor.DEVICE, 'device': 'press', 'type': 'handshake', 'parameters': (('a', '1'),)},
     'must not have parameters'),
    ({'on_failure': Policy.RETRY}, 'needs retries'), ({'retries': 1}, 'needs retries'),
    ({'load': LoadEffect.TAKES, 'blocking': StepBlocking.SOFT}, 'must be HARD'),
    ({'load': LoadEffect.GIVES, 'when': When.BEFORE_LEAVING}, 'AT the stop'),
    ({'load': LoadEffect.TAKES, 'on_failure': Policy.SKIP}, 'without a person'),
    ({'load': LoadEffect.TAKES, 'harmless': True}, 'not harmless')])
def test_a_step_that_makes_no_sense_is_refused_by_its_place(changes, told):
    check_stops((WorkStop(1, steps=(STEP,)),), ())
    wrong = WorkStop(1, steps=(STEP, replace(STEP, **changes)))
    with pytest.raises(WrongStops, match=rf'step 2 \(.*\) of stop 1 .*{told}'):
        check_stops((wrong,), ())
    with pytest.raises(WrongStops, match='of stop of on_cancel 2'):
        check_stops((), (WorkStop(1), wrong))


def test_a_stop_has_a_limited_number_of_steps():
    with pytest.raises(WrongStops, match=f'stop 1 has more than {MOST_STEPS} steps'):
        check_stops((WorkStop(1, steps=(STEP,) * (MOST_STEPS + 1)),), ())


def test_a_mission_has_a_limited_number_of_stops():
    check_stops((WorkStop(1),) * (MOST_STOPS - 1), (WorkStop(1),))
    with pytest.raises(WrongStops, match=f'more than {MOST_STOPS} stops'):
        check_stops((WorkStop(1),) * MOST_STOPS, (WorkStop(1),))


def test_a_request_for_a_group_is_the_same_one_after_a_place_was_chosen():
    asked = Request(1, (0,), stops=(WorkStop(0, group='shelves'),))
    chosen = replace(asked, destinations=(42,), stops=(WorkStop(42, group='shelves'),))
    assert asked.is_repeat_of(chosen, True)
    assert not asked.is_repeat_of(replace(chosen, stops=(WorkStop(42, group='press'),)), True)


@pytest.mark.parametrize('condition', [Condition.LOADED, Condition.EMPTY])
def test_only_a_stop_of_on_cancel_has_a_condition(condition):
    stop = WorkStop(1, condition=condition)
    check_stops((WorkStop(1),), (stop,))
    with pytest.raises(WrongStops, match='stop 2 has a condition'):
        check_stops((WorkStop(1), stop), ())


def test_a_robot_that_may_not_be_sent_to_a_dock_of_on_cancel_does_not_serve_the_mission():
    acceptance = Acceptance(with_docks(corridor(5), 5), {
        'a': AGV, 'b': replace(AGV, name='b', docks=frozenset())})
    stops, away = (WorkStop(2),), (WorkStop(5, condition=Condition.LOADED),)
    request = Request(1, (2,), dwells=(-1.0,), stops=stops)
    assert acceptance.robots_for(request) == ('a', 'b')
    assert acceptance.robots_for(replace(request, on_cancel=away)) == ('a',)
    with pytest.raises(RequestRefused, match='no such robot may be sent to its dock'):
        acceptance.check(replace(request, on_cancel=away, robot='b'))


def test_a_robot_stays_where_it_has_to_work_and_at_the_last_stop():
    assert dwells_of((WorkStop(1), WorkStop(2, steps=(STEP,)), WorkStop(3))) == (0.0, -1.0, -1.0)


@pytest.mark.parametrize('stops, on_cancel, told', [
    ((WorkStop(3, steps=(replace(STEP, timeout=0.0),)),), (), 'needs a timeout'),
    ((WorkStop(3),), (WorkStop(99),), 'no edges lead to vertex 99'),
    ((), (WorkStop(3),), 'but no stops')])
def test_a_mission_whose_stops_cannot_be_made_is_refused(stops, on_cancel, told):
    acceptance = Acceptance(corridor(5), {'a': AGV})
    with pytest.raises(RequestRefused, match=told):
        acceptance.check(Request(1, (3,), stops=stops, on_cancel=on_cancel))


# -- the file -------------------------------------------------------------------------------------


def vertex(word: str) -> int:
    if word == 'press':
        return 18
    if not word.isdecimal():
        raise ValueError(f'no vertex has the label {word!r}')
    return int(word)


def read(tmp_path, text: str):
    path = tmp_path / 'work.yaml'
    path.write_text(text)
    return load_stops(path, vertex)


def test_a_file_gives_stops_with_all_keys(tmp_path):
    found = read(tmp_path, '''
stops:
- at: press
  kind: pickup
  steps:
  - {type: engage, timeout: 60, load: takes}
  - {type: say, timeout: 5.5, parameters: {text: hello, times: 2}, when: before_leaving,
     blocking: none, on_failure: retry, retries: 2, harmless: true, breakable: true}
- group: shelves
on_cancel:
- {if: loaded, at: 6, kind: dropoff, steps: [{type: wait, timeout: 9, actor: person}]}
''')
    assert found.stops == (
        WorkStop(18, StopKind.PICKUP, (
            WorkStep('engage', 60.0, load=LoadEffect.TAKES),
            WorkStep('say', 5.5, (('text', 'hello'), ('times', '2')), When.BEFORE_LEAVING,
                     blocking=StepBlocking.NONE, on_failure=Policy.RETRY, retries=2,
                     harmless=True, breakable=True))),
        WorkStop(0, group='shelves'))
    assert found.on_cancel == (WorkStop(6, StopKind.DROPOFF, (
        WorkStep('wait', 9.0, actor=Actor.PERSON),), Condition.LOADED),)


@pytest.mark.parametrize('text, line, told', [
    ('stops: []', 1, 'stops is empty'),
    ('stops:\n- {at: 1, kind: pickup, step: []}', 2, "unknown key 'step'; did you mean steps"),
    ('stops:\n- {at: 1, if: loaded}', 2, "unknown key 'if'"),
    ('stops:\n- at: 1\n  kind: pikup', 3, "kind is 'pikup'; did you mean pickup"),
    ('stops:\n- {at: nowhere}', 2, "no vertex has the label 'nowhere'"),
    ('stops:\n- {at: 1, steps: [{type: a}]}', 2, 'timeout is missing'),
    ('stops:\n- {at: 1, steps: [{type: a, timeout: 1, load: takes, blocking: soft}]}', 2, 'HARD'),
    ('stops:\n- {at: 1}\non_cancel:\n- {at: 2, iff: empty}', 4, 'did you mean if'),
    ('stops:\n- {at: 1, group: shelves}', 2, 'either at or group'),
    ("stops:\n- {group: ''}", 2, 'either at or group'),
    ('stops:\n- {kind: pickup}', 2, 'at is missing'),
    ('missions: []', 1, 'unknown key')])
def test_a_wrong_file_is_refused_with_its_line(tmp_path, text, line, told):
    with pytest.raises(FileError, match=told) as error:
        read(tmp_path, text)
    assert error.value.line == line


def test_a_last_stop_that_becomes_another_one_is_left_when_the_robot_has_passed_it():
    """While a step of an earlier stop keeps the robot at the last stop, stops are added."""
    going_on = replace(STEP, blocking=StepBlocking.NONE)
    work = work_of((WorkStop(1, steps=(going_on,)), WorkStop(2)), ())
    states = StopState.DONE, StopState.AT_WORK
    for number, state in enumerate(states):
        work = work.with_stop(number, replace(work.progress[number], state=state))
    situation, problem = rules.changed(Situation(1, work, RobotLoad()), (WorkStop(3), WorkStop(2)))
    assert not problem
    after = rules.passed(situation, 2).work
    assert after.current == 2 and after.progress[1].state is StopState.DONE
