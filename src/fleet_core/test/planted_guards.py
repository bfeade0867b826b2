"""Faults that the tests of the work at stops must find: each fault leaves one guard out.

For each guard, GUARDS has the object that is changed, the name of the function that is the guard,
and the function that replaces this function.
"""
from __future__ import annotations

from typing import Any, Mapping, Tuple

from fleet_core.work import rules
from fleet_core.work.stops import Actor
from fleet_core.work.tables import StepState, StopState
from fleet_core.work.work import Ending, StopProgress
from route_protocol import steps
from route_protocol.steps import ActorState, Reaction


def _takes_old_keys(state: ActorState, command: steps.StepCommand):
    after, reaction = _OBEY(state, command)
    is_over = any(one.key == command.key and one.word.is_final for one in state.steps)
    if command.act is steps.StepAct.DO and is_over and command.known_run == state.run:
        return state, Reaction.BEGIN
    return after, reaction


def _takes_other_runs(state: ActorState, command: steps.StepCommand):
    return _OBEY(state, steps.replace(command, known_run=state.run))


def _sends_all_keys(work, report):
    return [command for _, own_step, own in work.steps
            if own_step.actor is Actor.ROBOT and own.state is StepState.RUNNING
            and own.seen is not rules.Seen.OVER and own.run == report.run
            for command in [steps.StepCommand(own.key, steps.StepAct.DO, own.run, own_step.type)]]


def _load_stays(situation, place, key, run, now):
    return _BEGIN(situation, place, key, run, now)._replace(load=situation.load)


def _fails_at_once(situation, reason):
    return situation._replace(work=steps.replace(
        situation.work, ending=Ending.FAIL, is_cut=True, progress=tuple(
            StopProgress(StopState.FAILED, tuple(
                steps.replace(own, state=StepState.CANCELLED) for own in stop.steps))
            for stop in situation.work.progress)))


_OBEY, _BEGIN = ActorState.obey, rules.begin
GUARDS: Mapping[str, Tuple[Any, str, Any]] = {
    'a step has a key of its own': (
        rules, 'next_key', lambda work, last, now: last + 1),
    'a key is above all that the robot has taken': (
        rules, 'next_key', lambda work, last, now: max(own.key + 1 for _, _, own in work.steps)),
    'a mission that has become impossible ends its steps first': (
        rules, 'fail', _fails_at_once),
    'a stop that has begun is not replaced': (
        rules, 'has_begun', lambda stop: False),
    'a key is taken once': (
        ActorState, 'obey', _takes_old_keys),
    'a command of an earlier run is ignored': (
        ActorState, 'obey', _takes_other_runs),
    'a report of an earlier run is ignored': (
        rules, 'is_of_an_earlier_run', lambda report, own: False),
    'nothing begins while a person is asked': (
        rules, 'nobody_is_asked', lambda work: True),
    'the robot stands where a step needs it': (
        rules, 'stands_for', lambda step, where: True),
    'a hard step runs alone': (
        rules, 'blocks_none', lambda step, work: True),
    'the gate is closed while a step runs': (
        rules, 'gate_is_closed', lambda work: False),
    'the stop is not entered before its steps': (
        rules, 'place_not_to_enter', lambda work: None),
    'an unknown outcome is asked': (
        rules, 'may_be_repeated', lambda step, own: own.state is StepState.RUNNING),
    'a step that may still run is not retried': (
        rules, 'has_ended', lambda own: True),
    'a step that may still be begun is not answered': (
        rules, '_no_answer', lambda work, own, said: ''),
    'the load is unknown while it moves': (
        rules, 'begin', _load_stays),
}
