"""The record of a drive has the line that acknowledged the drive, and the doubt about the drive.

The doubt says since when and why the robot seems not to obey; the doubt ends with the command.
"""
from __future__ import annotations

import pytest
from drive_bench import OTHER, PERSON, ROUTE, Bench

from omron_arcl import Execution, Outcome
from omron_arcl.drives import MOST_OPEN, Unclear
from omron_arcl.judgements import SETTLE_OVERTAKEN
from omron_arcl.records import Fate, MotionCause, RecordKind


@pytest.fixture
def bench() -> Bench:
    return Bench()


def driving(bench: Bench, text: str = 'goto 12') -> Execution:
    """Returns a drive that the robot carries out."""
    execution = bench.drive(ROUTE, text)
    bench.robot(f'Going to {text.split()[-1]}')
    return execution


# --- the acknowledging line -----------------------------------------------------------------------

def test_it_is_the_line_with_which_the_robot_sets_out(bench):
    bench.drive(ROUTE)
    assert bench.memory.records[-1].acknowledged_by == ''
    bench.robot('Going to 12')
    assert bench.memory.ruling.acknowledged_by == 'Going to 12'


def test_it_may_be_a_status(bench):
    bench.drive(ROUTE)
    bench.status('Going to 12', 1.5)
    assert bench.memory.ruling.acknowledged_by == 'the robot\'s status is "Going to 12"'


def test_it_may_be_the_line_that_completes_the_drive(bench):
    bench.drive(ROUTE)
    bench.robot('Arrived at 12')
    assert bench.memory.ruling.acknowledged_by == 'Arrived at 12'


def test_it_may_come_after_an_outage(bench):
    bench.drive(ROUTE)
    bench.lose()
    bench.connect()
    bench.status('Going to 12')
    assert (bench.memory.giver, bench.memory.ruling.acknowledged_by) == (ROUTE, 'Going to 12')


def test_it_is_stored(bench):
    driving(bench)
    assert bench.kept[-1].ruling.acknowledged_by == 'Going to 12'


# --- the doubt ------------------------------------------------------------------------------------

def test_a_drive_that_another_client_stopped_is_doubted_on_its_record_until_its_command_ends(bench):
    """The memory then has the record of the other client's stop; the drive's is kept aside."""
    goto = driving(bench)
    bench.robot('Stopping')
    assert bench.memory.cause is MotionCause.OTHER_CLIENT
    assert [record.kind for record in bench.memory.records] == [RecordKind.FOREIGN_STOP]
    bench.status('Stopped', 1.5)
    record, began = bench.records.record_of(goto), bench.now
    assert (record.giver, record.goal, record.fate) == (ROUTE, '12', Fate.OBEYED)
    assert (record.doubt.why, record.doubt.outcome) == ('Stopping', Outcome.INTERRUPTED)
    assert began - 2.0 < record.doubt.since < began - 1.0
    bench.status('Stopped', 1.5)
    assert goto.result is None
    bench.status('Stopped', 1.5)
    assert (goto.result.outcome, goto.result.words) == (Outcome.INTERRUPTED, 'Stopping')
    assert bench.records.record_of(goto) is None
    assert not bench.records.in_doubt


def test_it_is_neither_stored_nor_published(bench):
    """A doubt contains a time on a clock that only this process has."""
    driving(bench)
    before, stored = bench.records.motion, len(bench.kept)
    bench.status('Stopped', 0.5)
    assert bench.records.in_doubt
    assert bench.records.motion == before
    assert len(bench.kept) == stored
    bench.drive(PERSON, 'goto 3')
    assert len(bench.kept) > stored
    assert [record.doubt for record in bench.kept[-1].records] == [None, None]


def test_it_ends_when_the_robot_confirms_the_drive(bench):
    goto = driving(bench)
    bench.status('Stopped', 1.5)
    assert bench.records.record_of(goto).doubt is not None
    bench.status('Going to 12', 1.5)
    assert bench.records.record_of(goto).doubt is None


def test_meanwhile_no_program_drives(bench):
    driving(bench)
    bench.status('Stopped', 1.5)
    with pytest.raises(Unclear):
        bench.drive(ROUTE, 'goto 3', known_epoch=bench.epoch)
    bench.status('Going to 12', 1.5)
    bench.drive(ROUTE, 'goto 3', known_epoch=bench.epoch)


def test_a_stop_that_is_sent_again_is_not_doubted_for_what_was_shown_before(bench):
    driving(bench)
    bench.status('Going to 12')
    stop = bench.stop(PERSON)
    bench.status('Going to 13', 1.5)
    assert bench.records.record_of(stop).doubt.outcome is Outcome.INTERRUPTED
    bench.status('Going to 13', SETTLE_OVERTAKEN)
    bench.pass_time(0.1)
    assert stop.result.outcome is Outcome.INTERRUPTED
    again = bench.stop(PERSON)
    assert bench.records.record_of(again).doubt is None


def test_a_stop_that_timed_out_leaves_no_doubt_on_its_record(bench):
    """The record of the stop stays, because the stop is still owed."""
    driving(bench)
    stop = bench.stop(PERSON)
    bench.status('Going to 13', 1.5)
    bench.robot('Unknown command stop')
    assert stop.result.outcome is Outcome.UNKNOWN_COMMAND
    owed = bench.memory.records[-1]
    assert owed.owed and owed.doubt is None


def test_each_drive_has_its_own(bench):
    first = driving(bench)
    second = bench.drive(OTHER, 'goto 3')
    bench.status('Stopped', 1.5)
    assert bench.records.record_of(first).doubt is not None
    assert bench.records.record_of(second).doubt is None


def test_a_command_is_doubted_however_many_were_given_after_it(bench):
    goto = driving(bench)
    for goal in range(1, MOST_OPEN):
        bench.drive(PERSON, f'goto {100 + goal}')
    for _ in range(5):
        bench.status('Stopped', 1.5)
    assert goto.result.outcome is Outcome.INTERRUPTED
