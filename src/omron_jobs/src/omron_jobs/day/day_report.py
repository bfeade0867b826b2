"""The figures of a day: in words, and one row for each job as CSV."""
from __future__ import annotations

import csv
import io
import math
from collections import Counter
from typing import Iterable, List, Sequence

from fleet_simulation.statistics import quantile
from node_program.inert_text import cell
from omron_jobs.day.day_run import PlayedDay
from omron_jobs.day.judge import WatchedJob

SHOWN = 10          # largest number of entries in each list: late jobs, refusals, broken promises
_COLUMNS = ('job', 'line', 'queued', 'robot', 'wait_s', 'lead_s', 'state')
_GOOD = 'No job was lost, and none was done twice. All lines that were told are true.'


def wait_of(job: WatchedJob) -> float:
    """Returns how long (s) it took until a robot drove to the first goal; NaN: no robot did."""
    return job.segments[0].drove - job.queued


def lead_of(job: WatchedJob) -> float:
    """Returns how long (s) it took until the job was completed; NaN: it never was."""
    return job.ended - job.queued if job.state == 'Completed' else math.nan


def in_words(day: PlayedDay, late: float) -> str:
    """Returns the figures of a day as text. `late`: s after which a job is late."""
    completed = [job for job in day.jobs if job.state == 'Completed']
    ends = Counter(job.state for job in day.jobs)
    lines = [f'{_count(len(day.jobs), "job")} in {day.hours:.1f} h with '
             f'{_count(day.robots, "robot")}: '
             + ', '.join(f'{number} {state}' for state, number in ends.most_common()),
             f'Completed jobs per hour: {len(completed) / max(day.hours, 1e-9):.1f}'
             + _busiest(day, completed),
             f'Wait until a robot sets out:  {_times(wait_of(job) for job in day.jobs)}',
             f'Lead time until the end:      {_times(lead_of(job) for job in completed)}']
    lines += _late_ones(day, late)
    lines += _listed(f'Refused commands: {len(day.refused)}', [
        f'line {line.number}, {clock(line.at)}: {reply.partition(" ")[2]}'
        for line, reply in day.refused])
    lines += _listed(f'BROKEN PROMISES: {len(day.wrong)}', day.wrong) if day.wrong else [_GOOD]
    return '\n'.join(lines)


def _busiest(day: PlayedDay, completed: Sequence[WatchedJob]) -> str:
    hours = Counter(int((day.begin + job.ended) // 3600) for job in completed)
    if len(hours) < 2:
        return ''
    hour, number = max(hours.items(), key=lambda one: (one[1], -one[0]))
    return f'; {number} from {hour % 24:02d}:00 to {(hour + 1) % 24:02d}:00'


def _late_ones(day: PlayedDay, late: float) -> List[str]:
    def lateness(job: WatchedJob) -> float:
        lead = lead_of(job)
        return -1.0 if math.isnan(lead) else lead
    found = sorted((job for job in day.jobs if lateness(job) > late), key=lateness, reverse=True)
    return _listed(f'Late (more than {_time(late)}): {len(found)}', [
        f'{job.id} of line {job.line}, queued at {clock(day.begin + job.queued)}: '
        f'{_time(lateness(job))}' for job in found])


def _listed(title: str, items: Sequence[str]) -> List[str]:
    more = [f'  and {len(items) - SHOWN} more'] if len(items) > SHOWN else []
    return [title, *(f'  {one}' for one in items[:SHOWN]), *more]


def _times(values: Iterable[float]) -> str:
    known = [value for value in values if not math.isnan(value)]
    if not known:
        return '-'
    return (f'half {_time(quantile(known, 0.5))}, 95 % {_time(quantile(known, 0.95))}, '
            f'longest {_time(max(known))}')


def _time(seconds: float) -> str:
    return f'{seconds:.0f} s' if seconds < 100.0 else f'{seconds / 60.0:.1f} min'


def clock(seconds: float) -> str:
    """Returns a time (s after midnight) as a time of day."""
    whole = round(seconds)
    return f'{whole // 3600 % 24:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}'


def _count(number: int, what: str) -> str:
    return f'{number} {what}' + ('' if number == 1 else 's')


def as_csv(day: PlayedDay) -> str:
    """Returns one row for each job."""
    table = io.StringIO()
    rows = csv.writer(table)
    rows.writerow(_COLUMNS)
    for job in day.jobs:
        times = ('' if math.isnan(one) else f'{one:.1f}' for one in (wait_of(job), lead_of(job)))
        rows.writerow(cell(str(one)) for one in (
            job.id, job.line, clock(day.begin + job.queued), job.segments[-1].robot, *times,
            job.state))
    return table.getvalue()
