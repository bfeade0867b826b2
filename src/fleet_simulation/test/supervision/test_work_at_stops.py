"""Missions with steps in a supervised fleet: stops, answers, cancellations, loads and restarts."""
from __future__ import annotations

from dataclasses import replace
from typing import Optional

import pytest
from fleet_builders import AGV, corridor

from fleet_core.interlocking import interlocking
from fleet_core.supervision.fleet_view import robot_views
from fleet_core.supervision.missions import (
    CommandKind,
    MissionChange,
    MissionState,
    Request,
    StepAnswer,
)
from fleet_core.supervision.waits import WaitCode
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import (
    Actor,
    Condition,
    LoadEffect,
    Policy,
    StepBlocking,
    When,
    dwells_of,
)
from fleet_core.work.stops import (
    WorkStep as Step,
)
from fleet_core.work.stops import (
    WorkStop as Stop,
)
from fleet_core.work.tables import LoadState, StopState
from fleet_simulation.agv.steps import SimulatedSteps
from route_protocol.steps import MOST_KEY, StepAct, StepCommand, Word
from world.supervised_fleet import SupervisedFleet

TAKE = Step('take', 60.0, load=LoadEffect.TAKES)
GIVE = Step('give', 60.0, load=LoadEffect.GIVES)


class WorkingFleet(SupervisedFleet):
    """A fleet on a corridor of eight vertices, whose robots carry out steps."""

    def __init__(self, *robots: str, **more: object) -> None:
        names = robots or ('a',)
        super().__init__(corridor(8), {name: (AGV, 1 + 7 * k) for k, name in enumerate(names)},
                         **more)
        self.steps = {name: SimulatedSteps(lambda: 1) for name in names}

    def send(self, id: int, *stops: Stop, on_cancel: tuple = (), **more: object) -> None:
        self.do(self.supervisor.request(Request(
            id, tuple(stop.place for stop in stops), dwells=dwells_of(stops), stops=stops,
            on_cancel=on_cancel, **more), self.now))

    def command(self, id: int, command: CommandKind) -> None:
        self.do(self.supervisor.command(id, command, self.now))

    def answer(self, id: int, answer: StepDecision) -> None:
        self.do(self.supervisor.command(id, CommandKind.ANSWER, self.now, StepAnswer(answer)))

    def set_load(self, name: str, mission: Optional[int] = None) -> str:
        problem, actions = self.supervisor.set_load(name, mission, self.now)
        self.do(actions)
        return problem

    def done(self, name: str = 'a') -> list:
        return self.steps[name].done

    def load(self, name: str = 'a') -> LoadState:
        return self.supervisor.desk.load(name).state

    def reason(self, id: int) -> str:
        return self.supervisor.book.find(id).reason

    def run_until_asked(self, id: int) -> None:
        self.run_until(lambda: self.state(id) is MissionState.NEEDS_PERSON)


def test_a_robot_takes_a_load_at_one_stop_and_gives_it_at_the_next():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(Step('engage', 60.0), TAKE)), Stop(6, steps=(GIVE,)))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    assert fleet.agvs['a'].visited == [1, 2, 3]
    fleet.run_until_done(1)
    assert fleet.told(1) == [MissionState.PENDING, MissionState.ACTIVE, MissionState.SUCCEEDED]
    assert fleet.done() == ['engage', 'take', 'give'] and fleet.load() is LoadState.EMPTY
    assert fleet.agvs['a'].visited == [1, 2, 3, 4, 5, 6]


def test_stops_without_steps_are_passed_as_destinations_are():
    with_stops, without = WorkingFleet(), WorkingFleet()
    with_stops.send(1, Stop(3), Stop(7))
    without.request(1, 3, 7)
    assert with_stops.run_until_done(1) == pytest.approx(without.run_until_done(1), abs=0.2)


def test_a_robot_stands_while_a_step_runs_though_another_one_wants_its_place():
    fleet = WorkingFleet('a', 'b')
    fleet.send(1, Stop(4, steps=(Step('wait', 90.0, (('seconds', '30'),)),)), robot='a')
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    fleet.request(2, 2, robot='b')
    fleet.run(20.0)
    assert fleet.agvs['a'].visited == [1, 2, 3, 4] and fleet.state(1) is MissionState.ACTIVE
    assert robot_views(fleet.supervisor, fleet.now)[0].waits_for.text == 'step 1 (wait) of stop 1'


def test_a_step_that_need_not_block_runs_while_the_robot_drives_on():
    fleet = WorkingFleet()
    beacon = Step('beacon', 90.0, (('seconds', '20'),), blocking=StepBlocking.NONE)
    fleet.send(1, Stop(2, steps=(beacon,)), Stop(5))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 5)
    assert fleet.done() == [] and fleet.state(1) is MissionState.ACTIVE
    fleet.run_until_done(1)
    assert fleet.done() == ['beacon']


def test_a_robot_waits_in_front_of_its_stop_until_a_step_before_the_entry_has_ended():
    fleet = WorkingFleet()
    ask = Step('ask', 90.0, (('seconds', '15'),), when=When.BEFORE_ENTRY)
    fleet.send(1, Stop(5, steps=(Step('work', 60.0), ask)))
    fleet.run_until(lambda: fleet.reason(1).startswith('step 2'))
    fleet.run(10.0)
    assert fleet.agvs['a'].visited == [1, 2, 3, 4]
    fleet.run_until_done(1)
    assert fleet.done() == ['ask', 'work'] and fleet.agvs['a'].visited[-1] == 5


@pytest.mark.parametrize('policy, retries, failures, end, done', [
    (Policy.FAIL, 0, 1, MissionState.FAILED, []),
    (Policy.SKIP, 0, 1, MissionState.SUCCEEDED, ['next']),
    (Policy.RETRY, 2, 2, MissionState.SUCCEEDED, ['step', 'next']),
    (Policy.RETRY, 2, 3, MissionState.NEEDS_PERSON, []),
    (Policy.ASK, 0, 1, MissionState.NEEDS_PERSON, [])])
def test_the_policy_of_a_step_says_what_follows_its_failure(policy, retries, failures, end, done):
    fleet = WorkingFleet()
    fleet.steps['a'].fail_next(Word.FAILED, failures)
    fleet.send(1, Stop(3, steps=(Step('step', 60.0, on_failure=policy, retries=retries),
                                 Step('next', 60.0))))
    fleet.run_until(lambda: fleet.state(1) is end)
    fleet.run(10.0)
    assert fleet.done() == done and fleet.state(1) is end


@pytest.mark.parametrize('answer, end, done', [
    (StepDecision.RETRY, MissionState.SUCCEEDED, ['step', 'next']),
    (StepDecision.SKIP, MissionState.SUCCEEDED, ['next']),
    (StepDecision.DONE, MissionState.SUCCEEDED, ['next']),
    (StepDecision.FAIL, MissionState.FAILED, [])])
def test_a_person_answers_a_step_whose_outcome_is_unknown(answer, end, done):
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(Step('step', 60.0, on_failure=Policy.SKIP), Step('next', 60.0))))
    fleet.run_until(lambda: fleet.steps['a'].running)
    fleet.steps['a'].restart()
    fleet.run_until_asked(1)
    assert fleet.supervisor.book.find(1).status.asks
    assert 'mission answer 1 retry|skip|fail|done' in fleet.reason(1)
    fleet.run(30.0)
    assert fleet.done() == []
    fleet.answer(1, answer)
    fleet.run_until_done(1)
    assert fleet.state(1) is end and fleet.done() == done


def test_a_step_that_does_not_end_in_time_asks_and_is_not_repeated_while_it_runs():
    fleet = WorkingFleet()
    fleet.steps['a'].fail_next(Word.RUNNING, 1)
    fleet.send(1, Stop(3, steps=(Step('step', 20.0),)))
    fleet.run_until_asked(1)
    fleet.answer(1, StepDecision.RETRY)
    assert fleet.state(1) is MissionState.NEEDS_PERSON
    assert fleet.statuses[-1].reason == (
        'ANSWER is not done: step step still runs: wait until it ends')
    fleet.steps['a'].restart()
    fleet.run(2.0)
    fleet.answer(1, StepDecision.RETRY)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_person_and_a_program_do_steps_by_an_answer():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(Step('load it', 600.0, actor=Actor.PERSON),
                                 Step('handshake', 600.0, actor=Actor.OUTSIDE))))
    for words in ('load it', 'handshake'):
        fleet.run_until(lambda: f'({words}) of stop 1 by' in fleet.reason(1))  # noqa: B023
        fleet.run(5.0)
        fleet.answer(1, StepDecision.DONE)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.done() == []


def test_a_cancelled_mission_ends_its_running_step_first_and_brings_its_load_away():
    fleet = WorkingFleet()
    away = Stop(8, steps=(GIVE,), condition=Condition.LOADED)
    empty = Stop(2, steps=(Step('wash', 60.0),), condition=Condition.EMPTY)
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(6, steps=(GIVE,)), on_cancel=(empty, away))
    fleet.run_until(lambda: fleet.load() is LoadState.UNKNOWN)
    fleet.command(1, CommandKind.CANCEL)
    assert fleet.state(1) is MissionState.CANCELLING
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.CANCELLED and fleet.load() is LoadState.EMPTY
    assert fleet.done() == ['take', 'give'] and fleet.agvs['a'].visited[-1] == 8
    assert fleet.reason(1) == 'cancelled on request'


def test_a_breakable_step_is_broken_off_by_a_cancellation():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(Step('wait', 900.0, (('seconds', '600'),), breakable=True),)))
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    fleet.command(1, CommandKind.CANCEL)
    fleet.run_until_done(1, limit=5.0)
    assert fleet.state(1) is MissionState.CANCELLED and fleet.done() == []


def test_a_loaded_robot_without_a_place_for_its_load_waits_for_a_person_and_serves_nobody_else():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(6, steps=(GIVE,)))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    fleet.command(1, CommandKind.CANCEL)
    fleet.request(2, 7)
    fleet.run(30.0)
    assert fleet.state(1) is MissionState.NEEDS_PERSON
    assert fleet.state(2) is MissionState.PENDING
    assert '`fleet load a empty`' in fleet.reason(1)
    assert not fleet.set_load('a')
    fleet.run_until_done(1, 2)
    assert fleet.state(1) is MissionState.CANCELLED and fleet.state(2) is MissionState.SUCCEEDED


def test_a_robot_keeps_the_load_of_a_failed_mission_until_a_person_takes_it():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(6, steps=(Step('gate', 60.0,
                                                              on_failure=Policy.FAIL), GIVE)))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    fleet.steps['a'].fail_next(Word.FAILED, 1)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.FAILED
    fleet.request(2, 7)
    fleet.restart()
    fleet.run(20.0)
    assert fleet.state(2) is MissionState.PENDING and fleet.load() is LoadState.LOADED
    assert 'fleet load a empty' in robot_views(fleet.supervisor, fleet.now)[0].waits_for.text
    fleet.set_load('a')
    fleet.run_until_done(2)


def test_the_robot_of_a_loaded_mission_may_need_a_person_without_losing_the_mission():
    fleet = WorkingFleet('a', 'b')
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(5, steps=(GIVE,)), robot='')
    fleet.run_until(lambda: fleet.load('a') is LoadState.LOADED)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    fleet.run(20.0)
    assert fleet.robot_of(1) == 'a' and fleet.state(1).is_open
    assert not fleet.bring_in('a')
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.done('a') == ['take', 'give']


def test_a_manager_that_is_restarted_at_any_moment_repeats_no_step():
    whole = WorkingFleet()
    whole.send(1, Stop(3, steps=(TAKE, Step('n', 60.0, blocking=StepBlocking.NONE))),
               Stop(4, steps=(GIVE,)))
    whole.run_until_done(1)
    commits = whole.disk.journal.commits
    assert commits > 10
    for crash_at in range(1, commits):
        for dies_after in (0, 1):
            fleet = WorkingFleet()
            fleet.crash_at, fleet.dies_after = crash_at, dies_after
            fleet.send(1, Stop(3, steps=(TAKE, Step('n', 60.0, blocking=StepBlocking.NONE))),
                       Stop(4, steps=(GIVE,)))
            if fleet.supervisor.book.find(1) is None:  # the journal did not have the mission yet
                continue
            fleet.run_until_done(1)
            assert fleet.state(1) is MissionState.SUCCEEDED
            assert sorted(fleet.done()) == ['give', 'n', 'take']
            fleet.end()


def test_messages_that_are_lost_or_come_twice_change_nothing():
    for seed in range(5):
        fleet = WorkingFleet(seed=seed, loss=0.3, repeats=0.3)
        fleet.send(1, Stop(3, steps=(TAKE, Step('n', 60.0, blocking=StepBlocking.NONE))),
                   Stop(4, steps=(GIVE,)))
        fleet.run_until_done(1)
        assert sorted(fleet.done()) == ['give', 'n', 'take'], seed
        fleet.end()


def test_no_step_begins_while_the_fleet_is_stopped_or_the_mission_is_paused():
    fleet = WorkingFleet()
    fleet.send(1, Stop(1, steps=(Step('one', 60.0), Step('two', 60.0))))
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    fleet.command(1, CommandKind.PAUSE)
    fleet.run(20.0)
    assert fleet.done() == ['one'] and fleet.state(1) is MissionState.PAUSED
    fleet.do(fleet.supervisor.stop_fleet(fleet.now))
    fleet.command(1, CommandKind.RESUME)
    fleet.run(20.0)
    assert fleet.done() == ['one']
    fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    fleet.run_until_done(1)
    assert fleet.done() == ['one', 'two']


def test_a_robot_whose_driver_shows_no_steps_begins_none_and_can_be_cancelled():
    fleet = WorkingFleet()
    fleet.steps.clear()
    fleet.send(1, Stop(3, steps=(TAKE,)))
    fleet.run(30.0)
    assert fleet.state(1) is MissionState.ACTIVE and fleet.load() is LoadState.EMPTY
    assert 'a shows no steps' in fleet.reason(1)
    assert robot_views(fleet.supervisor, fleet.now)[0].waits_for.code is WaitCode.PERSON
    fleet.command(1, CommandKind.CANCEL)
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.CANCELLED


@pytest.mark.parametrize('command, told', [
    (CommandKind.RELEASE, 'goes on when its steps have ended'),
    (CommandKind.ANSWER, 'no such step waits for an answer')])
def test_a_command_that_does_not_fit_is_answered(command, told):
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)))
    fleet.run(1.0)
    if command is CommandKind.ANSWER:
        fleet.answer(1, StepDecision.SKIP)
    else:
        fleet.command(1, command)
    assert any(told in text for text in fleet.notes)


def test_a_clean_up_passes_its_stops_without_steps():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(6, steps=(GIVE,)),
               on_cancel=(Stop(5), Stop(8, steps=(GIVE,))))
    fleet.run_until(lambda: fleet.load() is LoadState.LOADED)
    fleet.command(1, CommandKind.CANCEL)
    fleet.run_until_done(1, limit=120.0)
    assert fleet.state(1) is MissionState.CANCELLED and fleet.done() == ['take', 'give']


@pytest.mark.parametrize('is_paused', [False, True])
def test_a_mission_that_a_new_graph_makes_impossible_fails_when_its_step_has_ended(is_paused):
    fleet = WorkingFleet()
    fleet.send(1, Stop(2, steps=(Step('work', 900.0, (('seconds', '60'),)),)), Stop(8))
    fleet.run_until(lambda: fleet.steps['a'].running)
    if is_paused:
        fleet.command(1, CommandKind.PAUSE)
    fleet.restart(corridor(7))
    fleet.request(2, 5)
    fleet.run_until(lambda: not fleet.state(1).is_open)
    assert fleet.state(1) is MissionState.FAILED and 'vertex 8' in fleet.reason(1)
    assert fleet.done() == ['work'] and fleet.agvs['a'].visited == [1, 2]
    fleet.run_until_done(2)


@pytest.mark.parametrize('event', ['the fleet is stopped', 'the robot is taken out of service'])
def test_a_step_that_was_ordered_does_not_begin_after(event):
    fleet = WorkingFleet()
    steps, lost = fleet.steps['a'], []
    receive, steps.receive = steps.receive, lost.append
    fleet.send(1, Stop(1, steps=(Step('work', 60.0),)))
    fleet.run_until(lambda: lost)
    fleet.do(fleet.supervisor.stop_fleet(fleet.now) if 'fleet' in event
             else fleet.supervisor.take_out('a', fleet.now))
    steps.receive = receive
    fleet.run(10.0)
    assert not steps.running and not steps.done
    if 'fleet' in event:
        fleet.do(fleet.supervisor.resume_fleet(fleet.now)[1])
    else:
        assert not fleet.bring_in('a')
    fleet.run_until_done(1)
    assert fleet.done() == ['work']


def test_a_mission_whose_first_step_was_done_by_one_robot_is_not_begun_by_another():
    fleet = WorkingFleet('a', 'b')
    open_it = Step('open', 60.0, when=When.BEFORE_ENTRY, blocking=StepBlocking.NONE)
    fleet.send(1, Stop(4, steps=(open_it, Step('work', 60.0))))
    fleet.run_until(lambda: fleet.done('a') == ['open'])
    fleet.run(1.0)
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    assert fleet.state(1) is MissionState.FAILED
    fleet.run(20.0)
    assert fleet.done('b') == []


def test_a_mission_without_steps_stays_with_the_robot_that_carries_its_load():
    fleet = WorkingFleet('a', 'b')
    fleet.request(1, 4)
    fleet.run_until(lambda: fleet.robot_of(1))
    name = fleet.robot_of(1)
    assert not fleet.set_load(name, 1)
    fleet.do(fleet.supervisor.take_out(name, fleet.now))
    fleet.run(30.0)
    assert fleet.robot_of(1) == name and fleet.state(1).is_open


# -- a robot that a person moves away from its stop ----------------------------------------------


def moved_to(fleet: WorkingFleet, edge: int, name: str = 'a') -> None:
    """Lets a person take a robot out, carry it to an edge's start, and bring it in."""
    fleet.do(fleet.supervisor.take_out(name, fleet.now))
    fleet.agvs[name].be_carried(edge, 0.0)
    fleet.run(2.0)
    assert not fleet.bring_in(name)


def working_fleet(*words: Word) -> WorkingFleet:
    """Returns a fleet whose robot works at its first stop. Its first steps end with `words`."""
    fleet = WorkingFleet()
    for word in words:
        fleet.steps['a'].fail_next(word, 1)
    fleet.send(1, Stop(3, steps=(Step('work', 20.0),)), Stop(6))
    fleet.run_until(lambda: bool(fleet.steps['a'].running))
    return fleet


def stop_state(fleet: WorkingFleet, id: int = 1) -> StopState:
    work = fleet.supervisor.desk.work(fleet.supervisor.book.find(id).serial)
    return work.progress[work.current].state


def test_a_robot_that_was_moved_away_drives_back_and_repeats_its_step_there_when_a_person_says_so():
    fleet = working_fleet(Word.FAILED)
    fleet.steps['a'].restart()
    moved_to(fleet, 1)
    fleet.run_until_asked(1)
    fleet.run(10.0)
    assert fleet.done() == [] and stop_state(fleet) is StopState.DRIVING
    fleet.answer(1, StepDecision.RETRY)
    assert not fleet.steps['a'].running
    fleet.run_until(lambda: fleet.steps['a'].running)
    assert fleet.supervisor.robots['a'].position.vertex == 3
    fleet.run_until_done(1)
    assert fleet.done() == ['work'] and fleet.agvs['a'].visited[-1] == 6


@pytest.mark.parametrize('answer, end', [
    (StepDecision.SKIP, MissionState.SUCCEEDED), (StepDecision.DONE, MissionState.SUCCEEDED),
    (StepDecision.FAIL, MissionState.FAILED)])
def test_a_robot_that_was_moved_away_does_not_drive_back_for_a_step_that_is_over(answer, end):
    fleet = working_fleet()
    fleet.steps['a'].restart()
    moved_to(fleet, 4)
    fleet.run_until_asked(1)
    before = len(fleet.agvs['a'].visited)
    fleet.answer(1, answer)
    fleet.run_until_done(1)
    assert fleet.state(1) is end and 3 not in fleet.agvs['a'].visited[before:]


def test_a_robot_that_was_moved_away_drives_back_for_the_steps_that_are_left():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(Step('work', 20.0), Step('more', 20.0))))
    fleet.run_until(lambda: bool(fleet.steps['a'].running))
    fleet.steps['a'].restart()
    moved_to(fleet, 4)
    fleet.run_until_asked(1)
    fleet.answer(1, StepDecision.SKIP)
    fleet.run_until_done(1)
    assert fleet.done() == ['more'] and fleet.agvs['a'].visited[-1] == 3


@pytest.mark.parametrize('begins', [False, True])
def test_a_step_before_the_entry_is_repeated_in_front_of_its_stop(begins):
    fleet = WorkingFleet()
    steps, lost = fleet.steps['a'], []
    receive = steps.receive
    steps.receive = receive if begins else lost.append
    fleet.send(1, Stop(5, steps=(Step('ask', 60.0, when=When.BEFORE_ENTRY),)))
    fleet.run_until(lambda: lost or steps.running)
    if begins:
        steps.restart()
    steps.receive = receive
    moved_to(fleet, 1)
    fleet.run(5.0)
    assert not steps.running and not steps.done and fleet.state(1) is MissionState.NEEDS_PERSON
    fleet.answer(1, StepDecision.RETRY)
    fleet.run_until(lambda: steps.running)
    assert fleet.supervisor.robots['a'].position.vertex == 4
    fleet.run_until_done(1)
    assert fleet.done() == ['ask']


@pytest.mark.parametrize('hangs', [False, True])
def test_a_cancelled_mission_is_not_at_work_when_its_robot_was_moved_away(hangs):
    fleet = WorkingFleet()
    fleet.steps['a'].fail_next(Word.RUNNING, 1)
    fleet.send(1, Stop(3, steps=(replace(TAKE, timeout=5.0),)), Stop(8))
    fleet.run_until(lambda: bool(fleet.steps['a'].running))
    if hangs:
        fleet.run_until_asked(1)
    else:
        fleet.steps['a'].restart()
    fleet.command(1, CommandKind.CANCEL)
    fleet.run(1.0)
    moved_to(fleet, 1)
    assert fleet.state(1) is MissionState.NEEDS_PERSON and (
        stop_state(fleet) is StopState.DRIVING)
    fleet.steps['a'].restart()
    fleet.run(1.0)
    assert not fleet.set_load('a')
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.CANCELLED and fleet.done() == []


@pytest.mark.parametrize('restarts', [False, True])
def test_a_mission_whose_robot_drops_out_before_its_steps_begins_anew_with_another(restarts):
    fleet = WorkingFleet('a', 'b')
    fleet.send(1, Stop(3, steps=(Step('work', 20.0),)))
    fleet.run_until(lambda: fleet.agvs['a'].edge == 2)
    fleet.command(1, CommandKind.PAUSE)
    fleet.run_until(lambda: stop_state(fleet) is StopState.AT_WORK)
    assert fleet.robot_of(1) == 'a'
    fleet.do(fleet.supervisor.take_out('a', fleet.now))
    if restarts:
        fleet.restart()
    assert not fleet.robot_of(1) and stop_state(fleet) is StopState.WAITING
    fleet.command(1, CommandKind.RESUME)
    fleet.agvs['a'].be_carried(1, 0.0)
    fleet.run_until_done(1)
    assert fleet.done('a') == [] and fleet.done('b') == ['work']


# -- keys -----------------------------------------------------------------------------------------


def worked_before(fleet: WorkingFleet, name: str, key: int, *, runs: bool = False) -> None:
    """Lets the robot take a step of another fleet manager; `runs`: the step still runs."""
    steps = fleet.steps[name]
    seconds = '30' if runs else '0'
    steps.receive(StepCommand(key, StepAct.DO, 1, 'other', (('seconds', seconds),)))
    if not runs:
        steps.advance(0.0)


def test_a_clock_that_was_set_back_repeats_no_key():
    fleet = WorkingFleet()
    fleet.send(1, Stop(2, steps=(Step('one', 60.0),)))
    fleet.run_until_done(1)
    fleet.disk._clock = lambda: 1e6 + fleet.now
    fleet.restart()
    fleet.send(2, Stop(3, steps=(Step('two', 6e5), Step('three', 6e5))))
    fleet.run_until_done(2)
    assert fleet.state(2) is MissionState.SUCCEEDED and fleet.done() == ['one', 'two', 'three']


@pytest.mark.parametrize('last', [MOST_KEY, 2 ** 63, 2 ** 64 - 1])
def test_a_robot_whose_keys_are_used_up_hinders_no_other_and_gets_keys_when_it_restarts(last):
    fleet = WorkingFleet('a', 'b')
    worked_before(fleet, 'a', last)
    fleet.run(2.0)
    assert not fleet.set_load('a')
    fleet.send(1, Stop(1, steps=(Step('by hand', 6e5, actor=Actor.PERSON), Step('one', 60.0))),
               robot='a')
    fleet.send(2, Stop(8, steps=(Step('two', 60.0),)), robot='b')
    fleet.run_until_done(2)
    fleet.answer(1, StepDecision.DONE)
    fleet.run(5.0)
    assert fleet.state(1) is MissionState.ACTIVE and 'restart the program' in fleet.reason(1)
    fleet.steps['a'].restart()
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED


def test_a_robot_that_has_worked_since_the_journal_was_kept_needs_a_person_once():
    fleet = WorkingFleet()
    fleet.send(1, Stop(1, steps=(Step('work', 60.0),)), Stop(4))
    fleet.run(0.3)
    worked_before(fleet, 'a', int(3e12))
    fleet.restart()
    fleet.run(5.0)
    assert fleet.state(1) is MissionState.FAILED and 'journal is older' in fleet.reason(1)
    assert fleet.load() is LoadState.UNKNOWN
    assert not fleet.set_load('a')
    fleet.restart()
    fleet.run(5.0)
    assert fleet.load() is LoadState.EMPTY


@pytest.mark.parametrize('steps, done', [((Step('work', 60.0),), ['other', 'work']),
                                         ((), ['other'])])
def test_a_robot_stands_while_it_carries_out_a_step_of_another_fleet_manager(steps, done):
    fleet = WorkingFleet()
    worked_before(fleet, 'a', 5, runs=True)
    fleet.run(2.0)
    assert not fleet.set_load('a')
    fleet.send(1, Stop(1, steps=steps), Stop(3))
    fleet.run(20.0)
    assert fleet.steps['a'].running == ('other',) and fleet.agvs['a'].visited == [1]
    assert 'does not know' in fleet.reason(1) or not steps
    assert 'does not know' in robot_views(fleet.supervisor, fleet.now)[0].waits_for.text
    fleet.run_until_done(1)
    assert fleet.state(1) is MissionState.SUCCEEDED and fleet.done() == done


def test_without_its_gate_a_robot_enters_a_stop_before_the_step_has_ended(monkeypatch):
    monkeypatch.setattr(interlocking, 'CONDITIONS', tuple(
        one for one in interlocking.CONDITIONS if one.__name__ != '_stop_may_be_entered'))
    fleet = WorkingFleet()
    fleet.send(1, Stop(6, steps=(Step('ask', 900.0, (('seconds', '60'),), when=When.BEFORE_ENTRY,
                                      blocking=StepBlocking.NONE),)))
    fleet.run(50.0)
    assert fleet.agvs['a'].visited[-1] == 6 and not fleet.done()


# -- other stops ----------------------------------------------------------------------------------


def modify(fleet: WorkingFleet, id: int, *stops: Stop, priority: int = 0,
           first_stop: int = 0) -> str:
    """Gives a mission other stops; returns why this was refused, or an empty text."""
    count = len(fleet.statuses)
    fleet.do(fleet.supervisor.command(id, CommandKind.MODIFY, fleet.now,
                                      MissionChange(priority, (), stops, first_stop)))
    return next((status.reason for status in fleet.statuses[count:]
                 if status.command is CommandKind.MODIFY), '')


def test_stops_that_have_not_begun_are_replaced_while_the_robot_drives():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(8, steps=(GIVE,)))
    fleet.run_until(lambda: fleet.agvs['a'].visited[-1] == 4)
    assert modify(fleet, 1, Stop(6, steps=(GIVE,)), Stop(2)) == ''
    fleet.restart()
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED
    assert fleet.supervisor.book.find(1).request.destinations == (3, 6, 2)
    assert fleet.done() == ['take', 'give'] and fleet.load() is LoadState.EMPTY
    assert max(fleet.agvs['a'].visited) == 6


def test_a_stop_at_which_the_robot_works_is_not_replaced():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(replace(TAKE, actor=Actor.PERSON),)), Stop(8))
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    assert modify(fleet, 1, Stop(5, steps=(GIVE,))) == ''
    assert [stop.place for stop in fleet.supervisor.book.find(1).request.stops] == [3, 5]
    fleet.answer(1, StepDecision.DONE)
    fleet.run_until_done(1)
    assert fleet.told(1)[-1] is MissionState.SUCCEEDED and fleet.done() == ['give']


@pytest.mark.parametrize('first_stop, places', [(2, [3, 5]), (3, [3, 8, 5]), (4, [3, 8, 2, 5])])
def test_stops_before_the_first_one_that_is_replaced_are_kept(first_stop, places):
    fleet = WorkingFleet()
    fleet.send(1, Stop(3), Stop(8), Stop(2))
    assert modify(fleet, 1, Stop(5), first_stop=first_stop) == ''
    assert fleet.statuses[-1].destinations == tuple(places)
    fleet.restart()
    fleet.run_until_done(1)
    status = fleet.supervisor.stored_status(1, 0.0)
    assert (status.state, status.reached) == (MissionState.SUCCEEDED, len(places))
    assert status.destinations == tuple(places)


def test_a_change_that_comes_after_the_stop_that_it_replaces_has_begun_is_not_done():
    fleet = WorkingFleet()
    take = replace(TAKE, actor=Actor.PERSON)
    fleet.send(1, Stop(3, steps=(take,)), Stop(8))
    assert modify(fleet, 1, Stop(4, steps=(take,)), Stop(8), priority=5, first_stop=1) == ''
    assert (fleet.statuses[-1].priority, fleet.statuses[-1].destinations) == (5, (4, 8))
    assert 'none of number 4' in modify(fleet, 1, Stop(5), first_stop=4)
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    assert 'stop 1 has begun' in modify(fleet, 1, Stop(5), Stop(8), first_stop=1)
    assert 'but no stops' in modify(fleet, 1, first_stop=2)
    assert fleet.supervisor.book.find(1).request.destinations == (4, 8)


def test_a_stop_that_would_have_been_passed_gets_work_at_the_same_place():
    fleet = WorkingFleet()
    fleet.send(1, Stop(5), Stop(8, steps=(TAKE,)))
    fleet.run(1.0)
    assert modify(fleet, 1, Stop(5, steps=(TAKE,)), Stop(8, steps=(GIVE,)), priority=3) == ''
    fleet.run_until_done(1)
    assert fleet.done() == ['take', 'give']
    assert fleet.supervisor.book.find(1).request.priority == 3


def test_a_mission_that_waits_gets_other_stops_and_begins_with_them():
    fleet = WorkingFleet()
    fleet.send(1, Stop(8, steps=(TAKE, GIVE)))
    fleet.send(2, Stop(3, steps=(TAKE, GIVE)))
    assert modify(fleet, 2, Stop(6, steps=(TAKE, GIVE))) == ''
    fleet.restart()
    fleet.run_until_done(1, 2)
    assert fleet.supervisor.book.find(2).request.destinations == (6,)
    assert fleet.told(2)[-1] is MissionState.SUCCEEDED


def test_a_change_of_stops_that_makes_no_sense_is_refused_and_changes_nothing():
    fleet = WorkingFleet()
    fleet.send(1, Stop(3, steps=(TAKE,)), Stop(8, steps=(GIVE,)), on_cancel=(Stop(2),))
    fleet.request(2, 4)
    assert 'no vertex 99' in modify(fleet, 1, Stop(99))
    assert 'needs a timeout' in modify(fleet, 1, Stop(3, steps=(replace(TAKE, timeout=0.0),)))
    assert 'without steps gets other destinations' in modify(fleet, 2, Stop(3))
    fleet.run_until(lambda: fleet.reason(1).startswith('step 1'))
    fleet.command(1, CommandKind.CANCEL)
    assert fleet.state(1) is MissionState.CANCELLING
    assert 'it ends already' in modify(fleet, 1, Stop(5))
    assert [stop.place for stop in fleet.supervisor.book.find(1).request.stops] == [3, 8]
