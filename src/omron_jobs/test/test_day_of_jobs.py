"""A day of jobs against the simulated fleet: the example of a shift, and the judge's findings."""
from __future__ import annotations

import csv
import math
import runpy
from pathlib import Path
from typing import Callable, List, Sequence, Tuple

import pytest
from proofs import LONG, is_whole

from fleet_core.files.errors import FileError
from fleet_core.supervision.missions import MissionState, Status
from omron_jobs.day.command import main
from omron_jobs.day.day_file import read_day
from omron_jobs.day.day_report import in_words
from omron_jobs.day.day_run import PlayedDay
from omron_jobs.day.judge import GoalPlace, Judge

ROOT = Path(__file__).resolve().parents[3]
EXAMPLE = ROOT / 'examples' / 'day_of_jobs'
WHOLE = is_whole(__file__)
BEGIN, END = ('00:00', '24:00') if LONG else ('08:30', '09:30') if WHOLE else ('09:01', '09:04')
# In the example the job server restarts between two jobs. In the short slice there is only one job;
# both sides restart while a robot serves it.
RESTARTS = () if WHOLE else ('09:01:34 restart job_server', '09:02:04 restart fleet_manager')
GOALS = ('press', 'shelf', 'gate')

# -- the example -----------------------------------------------------------------------------------


def test_in_the_example_no_job_is_lost_or_done_twice_and_all_that_is_told_is_true(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [line for line in (EXAMPLE / 'day.txt').read_text().splitlines()
             if BEGIN <= line < END]
    lines = sorted([*lines, *RESTARTS])
    assert any(line.endswith('restart job_server') for line in lines)
    (tmp_path / 'day.txt').write_text('\n'.join(lines))
    assert main([str(tmp_path / 'day.txt'), f'--graph={ROOT}/maps/lab_graph.yaml',
                 f'--fleet={EXAMPLE}/fleet.yaml', f'--work={EXAMPLE}/work.yaml',
                 f'--csv={tmp_path}/jobs.csv']) == 0
    told = capsys.readouterr().out
    assert 'No job was lost, and none was done twice.' in told
    rows = list(csv.DictReader((tmp_path / 'jobs.csv').open()))
    jobs = [line.split()[-1] for line in lines if line.split()[1].startswith(('queueP', 'queueMu'))]
    assert [row['job'] for row in rows] == jobs
    assert {row['state'] for row in rows} <= {'Completed', 'Cancelled'}
    assert sum(row['state'] == 'Completed' for row in rows) > 0.8 * len(rows)


def test_the_example_is_what_its_program_makes() -> None:
    made = runpy.run_path(str(EXAMPLE / 'make_day.py'))['made_day'](1)
    assert (EXAMPLE / 'day.txt').read_text().splitlines()[1:] == made


# -- the file --------------------------------------------------------------------------------------


def test_a_line_has_a_time_and_a_command_and_names_segments_of_jobs_above() -> None:
    lines = read_day(['# a day', '', '06:00 queuePickupDropoff press shelf default 5 P1',
                      '06:00:30 queueModify @p1.2 goal "gate"', '06:01 restart job_server',
                      '23:59:59 queueMulti 2 2 gate pickup 1 shelf dropoff default'], GOALS)
    assert [(line.number, line.at, line.queues) for line in lines] == [
        (3, 21600.0, True), (4, 21630.0, False), (5, 21660.0, False), (6, 86399.0, True)]
    assert lines[1].command(lambda job, number: f'{job}-{number}') == 'queueModify p1-2 goal gate'


@pytest.mark.parametrize('line, problem', [
    ('6:00 queuePickup press', "'6:00' is no time of a day"),
    ('05:59 queuePickup press', '05:59 is before the line above'),
    ('06:10', 'there is no command after 06:10'),
    ('06:10 queuePickUp press', "there is no command 'queuePickUp': did you mean queuePickup"),
    ('06:10 queuePickup', 'queuePickup has 0 arguments here, but takes 1 to 3'),
    ('06:10 queuePickup pres', "the graph has no goal 'pres': did you mean press"),
    ('06:10 queuePickup press often', 'needs a whole number in the place of "often"'),
    ('06:10 queuePickup press 1 P1', 'a line above queues the job P1'),
    ('06:10 queuePickup press 1 JOB7', 'JOB7 is an id that the job server makes'),
    ('06:10 queueMulti 2 3 press pickup 1', 'needs a number of goals from 1 to 50, then 2'),
    ('06:10 queueMulti 2 2 press pickup 1', 'queueMulti has 5 arguments here'),
    ('06:10 queueMulti 1 2 press dropoff 1', 'the first goal of queueMulti must be a pickup'),
    ('06:10 queueMulti 1 2 press lift 1', "'lift' stands in the place of pickup or dropoff"),
    ('06:10 queueCancel jobid P1', "queueCancel has no type 'jobid'"),
    ('06:10 queueCancel jobId P2', "no line above queues a job with the id 'P2'"),
    ('06:10 queueCancel status done', "there is no status 'done' to be cancelled"),
    ('06:10 queueCancel id PICKUP1', "'PICKUP1' is no segment of a job"),
    ('06:10 queueModify @P1.2 goal gate', 'the job P1 has only 1 segments'),
    ('06:10 queueModify @P1.1 speed 3', "queueModify changes goal or priority, not 'speed'"),
    ('06:10 restart robot', "'robot' cannot be restarted"),
])
def test_a_wrong_line_is_named(line: str, problem: str) -> None:
    with pytest.raises(FileError, match='day, line 2: ') as refused:
        read_day(['06:00 queuePickup press 1 P1', line], GOALS)
    assert problem in str(refused.value)


def test_a_day_without_jobs_is_refused() -> None:
    with pytest.raises(FileError, match='the day has no jobs'):
        read_day(['06:00 restart job_server'], GOALS)


def test_wrong_input_of_the_command_is_one_sentence(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / 'none.txt'), f'--graph={tmp_path}/graph.yaml',
                 f'--fleet={EXAMPLE}/fleet.yaml']) == 1
    assert capsys.readouterr().err.count('\n') == 1


# -- the judge -------------------------------------------------------------------------------------

SEGMENTS = {'PICKUP1': 'press', 'DROPOFF2': 'shelf'}
REPLY = ('queuepickupdropoff goals "press" and "shelf" with priorities 10 and 20 ids PICKUP1 and '
         'DROPOFF2 job_id P1 successfully queued')
COURSE = ('Pending None', 'InProgress UnAllocated', 'InProgress Allocated', 'InProgress Driving',
          'Completed None')
GOOD: List[Tuple[str, str]] = [('PICKUP1', COURSE[0]), ('DROPOFF2', 'Pending ID_PICKUP1'),
                               *(('PICKUP1', state) for state in COURSE[1:]),
                               *(('DROPOFF2', state) for state in COURSE[1:])]
DONE = Status(1, MissionState.SUCCEEDED, 'r1', 2)
CANCELLED = Status(1, MissionState.CANCELLED, 'r1', 1)


def judged(told: Sequence[Tuple[str, str]], last: Status = DONE, serials: Tuple[int, ...] = (1,),
           visits: Sequence[str] = ('press', 'shelf'), cancel: str = '') -> List[str]:
    """The errors that the judge finds if the program gets these states of a job."""
    places = {name: GoalPlace(k, 10.0 * k, 0.0) for k, name in enumerate(GOALS)}
    judge = Judge(places)
    judge.hears_reply(3, [REPLY], 1.0)
    if cancel:
        judge.hears_reply(4, [f'queuecancel cancelling {cancel} "" "None" from queue'], 1.5)
    for now, (segment, state) in enumerate(told, 2):
        goal = SEGMENTS[segment]
        robot = 'None' if state.startswith('Pending') else 'r1'
        if state.startswith('Completed') and goal in visits:
            judge.sees('r1', places[goal].x + 0.2, 0.1, float(now))
        judge.hears(f'QueueUpdate: {segment} P1 10 {state} Goal "{goal}" "{robot}" 01/01/2026 '
                    '10:00:00 None None 0 ', float(now))
    judge.ends(judge.jobs[0], last, set(serials))
    return judge.wrong


def test_a_job_that_is_done_in_order_is_right() -> None:
    assert judged(GOOD) == []


def test_a_job_that_a_program_cancels_on_its_way_is_right() -> None:
    told = [*GOOD[:7], ('DROPOFF2', 'Cancelling late'), ('DROPOFF2', 'Interrupted None'),
            ('DROPOFF2', 'Cancelled late')]
    assert judged(told, CANCELLED, cancel='"jobId" "P1"') == []
    assert judged(told, CANCELLED, cancel='"id" "dropoff2"') == []
    wrong, = judged(told, CANCELLED, cancel='"jobId" "P2"')
    assert wrong == 'Job P1 (line 3) was cancelled by no program.'


@pytest.mark.parametrize('find, problem', [
    (lambda: judged([*GOOD[:3], *GOOD[4:]]), 'PICKUP1: Driving was told after UnAllocated'),
    (lambda: judged([*GOOD, GOOD[-1]]), 'DROPOFF2: Completed was told after Completed'),
    (lambda: judged([*GOOD[:5], *GOOD[6:], GOOD[5]]),
     'UnAllocated was told before the end of the segment before it'),
    (lambda: judged(GOOD, visits=('press',)), 'Completed was told, but r1 was not at its goal'),
    (lambda: judged(GOOD[:-1]), 'has not ended: it is told as Completed, Driving'),
    (lambda: judged(GOOD, serials=(1, 2)), 'became 2 missions'),
    (lambda: judged(GOOD, CANCELLED, cancel='"jobId" "P1"'),
     'was told as Completed, Completed, but its mission is CANCELLED after 1 stops'),
    (lambda: judged(GOOD, Status(1, MissionState.ACTIVE, 'r1', 2)), 'its mission is ACTIVE'),
])
def test_the_judge_finds(find: Callable[[], List[str]], problem: str) -> None:
    assert any(problem in wrong for wrong in find())


def test_the_judge_finds_an_id_that_is_used_twice_and_a_line_about_no_job() -> None:
    judge = Judge({})
    judge.hears_reply(1, [REPLY], 0.0)
    judge.hears_reply(2, [REPLY.replace('job_id P1', 'job_id P2')], 0.0)
    judge.hears('QueueUpdate: PICKUP9 P9 1 Pending None Goal "a" "None" None None 0 ', 0.0)
    assert judge.wrong[0] == 'The id PICKUP1 of job P2 is used twice.'
    assert 'about no job: QueueUpdate: PICKUP9' in judge.wrong[-1]


def test_broken_promises_and_late_jobs_are_told() -> None:
    judge = Judge({})
    judge.hears_reply(3, [REPLY], 60.0)
    job = judge.jobs[0]
    job.segments[-1].state, job.ended = 'Completed', 60.0 + 1500.0
    told = in_words(PlayedDay(21600.0, 1.0, 2, judge.jobs, (), ['Something is wrong.']), 1200.0)
    assert 'BROKEN PROMISES: 1\n  Something is wrong.' in told
    assert 'Late (more than 20.0 min): 1\n  P1 of line 3, queued at 06:01:00: 25.0 min' in told
    assert math.isnan(job.segments[0].drove) and 'Wait until a robot sets out:  -' in told
