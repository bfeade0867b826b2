"""Each row of the table of attributions has its effect; without the row, the result differs."""
from __future__ import annotations

from typing import Any, Callable, Dict, List, NamedTuple, Tuple, Union

import pytest
from drive_bench import DOCKED, DOCKING, ROUTE, UNDOCKED, UNDOCKING, Bench

from omron_arcl.attribution import ATTRIBUTIONS
from omron_arcl.records import MotionCause

FAULT = 'FaultCleared: Fault_Driving_Application f "s" "l" true false true'
REASON = 'CommandErrorDescription: not today'
POINT = 'Status: Going to 100 200 StateOfCharge: 80.0 Location: 0 0 0 Temperature: 30'
OTHERS, ITSELF, OURS, START = (
    MotionCause.OTHER_CLIENT, MotionCause.ROBOT, MotionCause.OTHER_GIVER, MotionCause.RESTART)


def outage(bench: Bench) -> None:
    """Breaks the link, and makes it again."""
    bench.lose()
    bench.connect()


def again(bench: Bench) -> None:
    """Gives the same drive again."""
    bench.drive(ROUTE)


class Occasion(NamedTuple):
    """A case for one row: the robot shows a status, gets commands, and then says lines.

    ends -- the outcome or state of each command
    cause -- why the present epoch began
    """

    shown: str
    commands: List[str]
    lines: List[Union[str, Callable[[Bench], None]]]
    ends: List[str]
    cause: MotionCause = START


OCCASIONS: Dict[str, Occasion] = {
    # rows that find the cause of a `Stopping`
    'our stop': Occasion('Stopped', ['stop'], ['Stopping', 'Stopped'], ['succeeded'],
                         MotionCause.STOP),
    'undocked': Occasion('Docked', ['undock'], [UNDOCKING, UNDOCKED, 'Stopping'], ['succeeded'],
                         OURS),
    'motors enabled': Occasion('Motors disabled', ['enableMotors'], ['Motors enabled', 'Stopping'],
                               ['succeeded']),
    'cleared fault': Occasion('Stopped', ['applicationFaultClear f'], [FAULT, 'Stopping'],
                              ['sent']),
    'attempt to dock': Occasion('Going to 5', ['dock'], ['Going to Dock1', DOCKING, 'Stopping'],
                                ['under way'], OURS),
    'replacement': Occasion('Going to 5', ['goto 12'], ['Stopping'], ['sent']),
    'our stop after all': Occasion('Going to 5', ['goto 12', 'stop'], ['Stopping', 'Stopped'],
                                   ['sent', 'under way'], MotionCause.STOP),
    'stands unasked': Occasion('Going to 5', ['goto 12'], ['Stopping', 'Stopped'],
                               ['sent'], OTHERS),
    'stop of another client': Occasion('Going to 5', [], ['Stopping'], [], OTHERS),
    # the giver has been told that its drive has ended; then the robot says what became of the drive
    'refused late': Occasion('Stopped', ['goto 12'],
                             ['EStop pressed', again, 'CommandError: goto 12', REASON],
                             ['emergency stop'], MotionCause.EMERGENCY_STOP),
    'broken off late': Occasion('Stopped', ['goto 12'],
                                [outage, 'Interrupted: Going to 12', 'Going to 12'],
                                ['lost'], OTHERS),
    # refusals
    'refused: whole line': Occasion('Stopped', ['gotoPoint 1 2', 'gotoPoint 3 4'],
                                    ['CommandError: gotoPoint 3 4', REASON], ['sent', 'rejected']),
    'refused: beginning': Occasion(
        'Stopped', ['executeMacro Adept 1', 'executeMacro Adept Greeting'],
        ['CommandError: executeMacro Adept Gr', REASON], ['sent', 'rejected']),
    'refused: name': Occasion('Stopped', ['goto 12'], ['CommandError: goto', REASON],
                              ['rejected']),
    'no goal': Occasion('Stopped', ['goto 99'],
                        ['CommandError: goto 99', 'CommandErrorDescription: No such goal'],
                        ['no such goal']),
    'no goal of this name': Occasion('Stopped', ['goto 99'], ["No goal '99'"], ['no such goal']),
    'no power': Occasion('Stopped', ['goto 12'],
                         ['CommandError: goto 12', 'CommandErrorDescription: EStop pressed'],
                         ['emergency stop'], MotionCause.EMERGENCY_STOP),
    'refused': Occasion('Stopped', ['getGoals'], ['CommandError: getGoals', REASON],
                        ['rejected']),
    'unknown command': Occasion('Stopped', ['arclStat', 'getGoals'], ['Unknown command arclStat'],
                                ['unknown command', 'sent']),
    'unknown command without a name': Occasion('Stopped', ['arclStat'], ['Unknown command'],
                                               ['unknown command']),
    'not set up': Occasion('Stopped', ['listAdd say x'], ['SetUpError: start a list first'],
                           ['rejected']),
    'usage': Occasion('Stopped', ['goto 12'], ['usage: goto <goal>'], ['rejected']),
    # failures and interruptions
    'interrupted': Occasion('Stopped', ['goto 12'], ['Going to 12', 'Interrupted: Going to 12'],
                            ['interrupted'], MotionCause.INTERRUPTED),
    'interrupted at its point': Occasion(
        'Stopped', ['goto 12'], ['Going to 12', POINT, 'Interrupted: Going to 100 200'],
        ['interrupted'], MotionCause.INTERRUPTED),
    'interrupted in other words': Occasion(
        'Stopped', ['goto 12'], ['Going to 12', 'Interrupted: something'], ['interrupted'],
        MotionCause.INTERRUPTED),
    'error': Occasion('Stopped', ['goto 12'], ['Going to 12', 'Error: Stalled'], ['failed'], OURS),
    'failed going to a goal': Occasion('Stopped', ['goto 12'],
                                       ['Going to 12', 'Failed going to 12'], ['failed'], OURS),
    'failed going': Occasion('Stopped', ['goto 12'], ['Going to 12', 'Failed going to goal'],
                             ['failed'], OURS),
    'failed to localize': Occasion('Stopped', ['localizeAtGoal 1'], ['Failed to localize'],
                                   ['failed']),
    'failed to begin': Occasion('Stopped', ['goto 12'], ['Cannot find path'], ['failed']),
    'emergency stop': Occasion('Stopped', ['goto 12'], ['Going to 12', 'EStop pressed'],
                               ['emergency stop'], MotionCause.EMERGENCY_STOP),
    'motors disabled': Occasion('Stopped', ['goto 12'], ['Going to 12', 'Motors disabled'],
                                ['failed'], OURS),
    # drives
    'completed': Occasion('Stopped', ['goto 12'], ['Going to 12', 'Arrived at 12'], ['succeeded'],
                          OURS),
    'acknowledged': Occasion('Stopped', ['goto 12'], ['Going to 12'], ['under way'], OURS),
    'broken off': Occasion('Docked', ['undock'], [UNDOCKING, DOCKED], ['interrupted'], OTHERS),
    'under way': Occasion('Stopped', ['doTask wait 1'], ['Doing task wait 1', 'Going to 5'],
                          ['under way'], OURS),
    # rows that find the giver for which the robot sets out
    'late start': Occasion('Stopped', ['goto 12'], [outage, 'Going to 12'], ['lost'], OURS),
    'docks by itself': Occasion('Stopped', [], [UNDOCKED, DOCKING], [], ITSELF),
    'drive of another client': Occasion('Stopped', [], ['Going to 9'], [], OTHERS),
    # answers
    'stands': Occasion('Stopped', ['stop', 'stop'], ['Stopping', 'Stopped'],
                       ['succeeded', 'succeeded'], MotionCause.STOP),
    'answer': Occasion('Stopped', ['odometer'], ['Odometer: 1 mm 2 deg 3 sec'], ['succeeded']),
    'part of an answer': Occasion('Stopped', ['getGoals'], ['Goal: 1', 'End of goals'],
                                  ['succeeded']),
    'answer that is not documented': Occasion('Stopped', ['arclStat'], ['ARCL is well'],
                                              ['under way']),
}
ROWS = {row.name: part for part, rows in ATTRIBUTIONS.items() for row in rows}


def play(occasion: Occasion) -> Tuple[List[str], MotionCause, Any]:
    """Returns the outcome or state of each command, the cause of the epoch, and other results."""
    bench = Bench()
    bench.status(occasion.shown)
    executions = [bench.give(command, giver=ROUTE) for command in occasion.commands]
    for line in occasion.lines:
        if isinstance(line, str):
            bench.robot(line)
        else:
            line(bench)
    ends = [e.result.outcome.value if e.result else 'under way' if bench.has_begun(e) else 'sent'
            for e in executions]
    return ends, bench.memory.cause, (
        bench.sent, bench.state, bench.memory.records, [e.result for e in executions])


def test_each_row_has_an_occasion_and_a_source():
    assert set(OCCASIONS) == set(ROWS)
    assert len(ROWS) == sum(map(len, ATTRIBUTIONS.values())), 'a name stands for two rows'
    assert all(row.source for rows in ATTRIBUTIONS.values() for row in rows)


@pytest.mark.parametrize('row', OCCASIONS)
def test_it_means(row):
    ends, cause, _ = play(OCCASIONS[row])
    assert (ends, cause) == (OCCASIONS[row].ends, OCCASIONS[row].cause)


@pytest.mark.parametrize('row', OCCASIONS)
def test_without_it_something_else_is_told(row, monkeypatch):
    expected = play(OCCASIONS[row])
    part = ROWS[row]
    monkeypatch.setitem(ATTRIBUTIONS, part,
                        tuple(one for one in ATTRIBUTIONS[part] if one.name != row))
    assert play(OCCASIONS[row]) != expected
