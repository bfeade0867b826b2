"""Steps of a simulated AGV: their duration, and faults on demand."""
from __future__ import annotations

import pytest
from agv_builders import Conversation

from fleet_simulation.agv.faults import inject
from fleet_simulation.agv.steps import SECONDS
from route_protocol.steps import StepAct, StepCode, StepCommand, Word


class Worker:
    """An AGV that gets steps."""

    def __init__(self) -> None:
        self.agv = Conversation()
        self.steps = self.agv.vehicle.steps
        self.key = 0

    def do(self, **parameters: str) -> int:
        self.key += 1
        self.steps.receive(StepCommand(self.key, StepAct.DO, self.steps.report().run, 'lift',
                                       tuple(parameters.items()), 60.0))
        return self.key

    def word(self, key: int) -> Word:
        return self.steps.report().find(key).word


def test_a_step_takes_its_time() -> None:
    worker = Worker()
    short, long = worker.do(), worker.do(seconds='9')
    worker.agv.wait(SECONDS + 0.2)
    assert (worker.word(short), worker.word(long)) == (Word.DONE, Word.RUNNING)
    worker.agv.wait(9.0)
    assert worker.word(long) is Word.DONE and worker.steps.done == ['lift', 'lift']


@pytest.mark.parametrize('seconds', ['-1', 'nan', 'soon', '1e9'])
def test_a_wrong_duration_fails_at_once(seconds: str) -> None:
    worker = Worker()
    key = worker.do(seconds=seconds)
    step = worker.steps.report().find(key)
    assert (step.word, step.code) == (Word.FAILED, StepCode.WRONG_PARAMETER)


@pytest.mark.parametrize('fault, word', [
    ('step_fails', Word.FAILED), ('step_unknown', Word.UNKNOWN), ('step_hangs', Word.RUNNING)])
def test_the_next_steps_end_as_a_fault_says(fault: str, word: Word) -> None:
    worker = Worker()
    inject(worker.agv.vehicle, f'{fault} 2')
    keys = [worker.do() for _ in range(3)]
    worker.agv.wait(60.0)
    assert [worker.word(key) for key in keys] == [word, word, Word.DONE]


def test_a_cancellation_ends_a_step() -> None:
    worker = Worker()
    key = worker.do(seconds='60')
    worker.steps.receive(StepCommand(key, StepAct.CANCEL, worker.steps.report().run))
    assert worker.word(key) is Word.CANCELLED and not worker.steps.running


@pytest.mark.parametrize('fault', ['step_driver', 'leave'])
def test_a_driver_that_was_restarted_has_forgotten_its_steps_and_has_a_later_run(fault: str,
                                                                                 ) -> None:
    worker = Worker()
    before = worker.steps.report().run
    worker.do(seconds='60')
    inject(worker.agv.vehicle, fault)
    if fault == 'leave':
        inject(worker.agv.vehicle, 'join')
    after = worker.steps.report()
    assert after.run > before and (after.last, after.steps) == (0, ())
    worker.agv.wait(60.0)
    assert worker.steps.done == []
