"""Random runs of a fleet with work: the fleet manager's knowledge of the steps agrees with the
truth.

Missions take and give loads, and are cancelled. Steps fail, hang, and end with an
unknown outcome. The steps' driver and the fleet manager restart, the fleet is stopped, and messages
are lost or arrive twice. A person looks at the robot, and answers truthfully.
"""
from __future__ import annotations

from functools import lru_cache
from random import Random
from typing import Dict, FrozenSet, List, Tuple

import pytest
from fleet_builders import AGV, corridor
from proofs import LONG, is_whole

from fleet_core.supervision.missions import CommandKind, MissionState, Request, StepAnswer
from fleet_core.work import rules
from fleet_core.work.rules import StepDecision
from fleet_core.work.stops import Condition, LoadEffect, dwells_of
from fleet_core.work.stops import WorkStep as Step
from fleet_core.work.stops import WorkStop as Stop
from fleet_core.work.tables import LoadState, StepState
from fleet_simulation.agv.steps import SimulatedSteps
from route_protocol.steps import Word
from world.supervised_fleet import SupervisedFleet

LIVES = 200 if LONG else 12 if is_whole(__file__) else 2
FAULTS = (Word.FAILED, Word.UNKNOWN, Word.RUNNING)
DISTURBED = 1500   # number of steps of the world with disturbances


class Life(SupervisedFleet):
    """A fleet of two robots on a corridor with a siding, and the person in charge of it."""

    def __init__(self, seed: int) -> None:
        super().__init__(corridor(8, siding_at=4), {'a': (AGV, 1), 'b': (AGV, 8)}, seed=seed,
                         loss=0.1, repeats=0.1)
        self.dice = Random(seed)
        self.steps = {name: SimulatedSteps(lambda: 1) for name in self.agvs}
        self.pieces: Dict[str, Tuple[int, int]] = dict.fromkeys(self.agvs, (0, 0))
        """For each robot: the number of its pieces, and how many of its done steps this number
        includes.
        """
        self.missions: List[int] = []
        self.places: Dict[str, object] = {}

    def carried(self, name: str) -> int:
        """The number of pieces that a robot really carries. An empty robot cannot give a piece
        away.
        """
        done = self.steps[name].done
        pieces, seen = self.pieces[name]
        for one in done[seen:]:
            if one.startswith('take'):
                pieces += 1
            elif one.startswith(('give', 'away')):
                pieces = max(pieces - 1, 0)
        self.pieces[name] = pieces, len(done)
        return pieces

    def unload(self, name: str) -> None:
        """A person takes everything from a robot."""
        self.carried(name)
        self.pieces[name] = 0, len(self.steps[name].done)

    def send(self) -> None:
        id = len(self.missions) + 1
        first, second, away = self.dice.sample(range(1, 9), 3)
        breakable = self.dice.random() < 0.5
        stops = (
            Stop(first, steps=(Step(f'look{id}', 20.0, breakable=breakable),
                               Step(f'take{id}', 20.0, load=LoadEffect.TAKES))),
            Stop(second, steps=(Step(f'give{id}', 20.0, load=LoadEffect.GIVES),)))
        on_cancel = (Stop(away, condition=Condition.LOADED, steps=(
            Step(f'away{id}', 20.0, load=LoadEffect.GIVES),)),) if self.dice.random() < 0.5 else ()
        self.missions.append(id)
        self.do(self.supervisor.request(Request(
            id, (first, second), dwells=dwells_of(stops), stops=stops, on_cancel=on_cancel),
            self.now))

    def open(self) -> List[int]:
        return [id for id in self.missions if self.supervisor.book.find(id) is not None
                and self.state(id).is_open]

    def disturb(self) -> None:
        chance, name = self.dice.random, self.dice.choice('ab')
        if len(self.open()) < 3 and chance() < 0.05:
            self.send()
        if chance() < 0.02:
            self.steps[name].fail_next(self.dice.choice(FAULTS), 1)
        if chance() < 0.004:
            self.steps[name].restart()
        if chance() < 0.004:
            self.restart()
        if chance() < 0.004 and self.open():
            self.do(self.supervisor.command(self.dice.choice(self.open()), CommandKind.CANCEL,
                                            self.now))
        if chance() < 0.004:
            self.do(self.supervisor.stop_fleet(self.now))
        if chance() < 0.03:
            self.answer()

    def answer(self) -> None:
        """A person resumes the fleet, looks at robots that need a person, and answers."""
        self.do(self.supervisor.resume_fleet(self.now)[1])
        serving = self.supervisor.book.serving
        for name in self.agvs:
            mission = serving.get(name)
            work = None if mission is None else self.supervisor.desk.work(mission.serial)
            place = None if work is None else work.asking
            load = self.supervisor.desk.load(name)
            if place is not None:
                self._say(name, mission.request.id, work.step(place).type)
            elif load.state is not LoadState.EMPTY and (
                    mission is None or mission.state is MissionState.NEEDS_PERSON):
                self.unload(name)
                self.do(self.supervisor.set_load(name, None, self.now)[1])

    def _say(self, name: str, mission: int, step: str) -> None:
        steps = self.steps[name]
        if step in steps.running:
            steps.restart()  # the step hangs: the person restarts the driver, and looks again
            return
        decision = StepDecision.DONE if step in steps.done else self.dice.choice(
            (StepDecision.RETRY, StepDecision.SKIP, StepDecision.FAIL))
        self.do(self.supervisor.command(mission, CommandKind.ANSWER, self.now,
                                        StepAnswer(decision)))

    def check(self) -> None:
        """Fails if the fleet manager's knowledge differs from the truth."""
        done = [one for steps in self.steps.values() for one in steps.done]
        assert len(done) == len(set(done)), f'a step was done twice: {done}'
        for name, agv in self.agvs.items():
            running, load = self.steps[name].running, self.supervisor.desk.load(name)
            if running:
                assert self.places.get(name) in (None, agv.position), f'{name} drives: {running}'
            self.places[name] = agv.position if running else None
            moves = any(one.startswith(('take', 'give', 'away')) for one in running)
            if load.state is LoadState.EMPTY:
                assert not (self.carried(name) or moves), f'{name} counts as empty'
            elif load.state is LoadState.LOADED:
                assert self.carried(name) == load.count and not moves, f'{name} counts as loaded'


def live(seed: int) -> Life:
    """Simulates a disturbed run of a fleet, and checks it after each step."""
    life = Life(seed)
    for _ in range(DISTURBED):
        life.disturb()
        life.step()
        life.check()
    return life


@lru_cache(maxsize=None)
def told_in(seed: int) -> FrozenSet[MissionState]:
    """Simulates until all missions end. Returns the states published during the disturbances."""
    life = live(seed)
    told = frozenset(status.state for status in life.statuses)
    for _ in range(200):
        life.run(5.0)
        life.answer()
        life.check()
        if not life.open():
            break
    assert not life.open(), [life.supervisor.book.find(id) for id in life.open()]
    life.end()
    return told


@pytest.mark.parametrize('seed', range(LIVES))
def test_what_the_fleet_knows_of_its_steps_and_loads_is_so_in_every_life(seed):
    assert told_in(seed), 'no mission changed its state'


PLANTS = {
    'twice': ('may_be_repeated', lambda step, own: own.state is StepState.RUNNING),
    'counts as': ('begin', lambda situation, *more: rules_begin(situation, *more)._replace(
        load=situation.load)),
}
rules_begin = rules.begin


@pytest.mark.parametrize('found', PLANTS)
def test_the_lives_find_a_guard_that_is_left_out(found, monkeypatch):
    monkeypatch.setattr(rules, *PLANTS[found])
    with pytest.raises(AssertionError, match=found):
        for seed in range(10):
            live(seed)


def test_the_lives_reach_what_they_are_to_test():
    told = frozenset().union(*map(told_in, range(4)))
    assert told >= {MissionState.SUCCEEDED, MissionState.FAILED, MissionState.CANCELLING,
                    MissionState.CANCELLED, MissionState.NEEDS_PERSON}
