"""Writes the report: one HTML file that needs no network, and CSV files with all figures."""
from __future__ import annotations

import csv
import io
import math
import os
from html import escape
from pathlib import Path
from typing import Callable, Dict, Iterable, List, NamedTuple, Sequence, Tuple

from file_replacement import replace_file
from fleet_simulation import svg
from fleet_simulation.figures import Figures, TimetableUse, Use, WaitingCause
from fleet_simulation.hold_ups import Bottleneck, HoldUp
from fleet_simulation.site import StudiedSite
from fleet_simulation.statistics import (
    Band,
    SizeResults,
    bottlenecks_of,
    keeps_up,
    knee,
    quantile,
    sizes,
    waiting_by_cause,
    waiting_by_drawn_edge,
    waiting_by_edge,
)
from node_program.inert_text import cell
from trajectory_graph import Graph

REPORT = 'report.html'
_TITLE = 'How many robots does this site need?'
_WORDS = ('no', 'one', 'two', 'three', 'four', 'five', 'six', 'seven', 'eight', 'nine', 'ten',
          'eleven', 'twelve')
_TOLD_EDGES = 10
_FEW_MINUTES = 0.6  # minutes of waiting per hour and robot that are not worth a sentence (1 %)
_STYLE = '''
body { font: 15px/1.45 sans-serif; max-width: 960px; margin: 2em auto; padding: 0 1em;
       color: #222; }
svg { font: 12px sans-serif; max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: 0.6em 0; }
th, td { border-bottom: 1px solid #ddd; padding: 3px 10px; text-align: right; }
th:first-child, td:first-child { text-align: left; }
.words { font-size: 1.15em; background: #f2f5f8; padding: 0.8em 1em; border-radius: 6px; }
.warning { background: #fff0e8; padding: 0.6em 1em; border-radius: 6px; }
'''


class Proposed(NamedTuple):
    """A simulated change of the graph.

    what -- the change in words, an imperative such as `cut edge 5`
    gain -- additional missions per hour
    file -- name of the file with the changed graph
    """

    what: str
    gain: Band
    file: str


class Study(NamedTuple):
    """All that a report shows.

    hours       -- virtual hours of each run
    command     -- the command line that requested the study
    ended_early -- whether Ctrl-C ended the study before all runs were completed
    proposals   -- simulated changes of the graph, the best first
    """

    site: StudiedSite
    runs: Sequence[Figures]
    hours: float
    command: str
    ended_early: bool = False
    proposals: Sequence[Proposed] = ()


def write(study: Study, folder: Path) -> Path:
    """Writes all files into the folder; returns the path of the HTML file.

    An older file is only replaced by a complete one.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, rows in _tables(study).items():
        table = io.StringIO()
        csv.writer(table).writerows([cell(str(one)) for one in row] for row in rows)
        replace_file(folder / name, table.getvalue())
    path = folder / REPORT
    replace_file(path, html(study))
    return path


def is_free(folder: Path) -> bool:
    """Whether reports may be written here: into a new or empty folder, or over an old report."""
    try:
        names = os.listdir(folder)
    except FileNotFoundError:
        return True
    if REPORT in names:
        return _TITLE in (folder / REPORT).read_text(encoding='utf-8', errors='replace')
    return not names


# -- words ----------------------------------------------------------------------------------------


def in_words(study: Study) -> str:
    """Returns the results of the study as one paragraph."""
    found = sizes(study.runs)
    if not found:
        return 'No run was completed.'
    best = knee(found)
    sentences = (_throughput_in_words(best), _demand_in_words(study, best),
                 _more_robots_in_words(found, best), _waiting_in_words(study, best),
                 _bottleneck_in_words(best), _deadlines_in_words(best),
                 _proposal_in_words(study), _failures_in_words(best))
    return ' '.join(filter(None, sentences))


def _throughput_in_words(best: SizeResults) -> str:
    lead_time = ''
    if best.leads:
        lead_time = (', 95 % of them with a lead time of up to '
                     f'{_time(quantile(best.leads, 0.95))}')
    return (f'{_count(best.robots, "robot")} {"serve" if best.robots != 1 else "serves"} '
            f'{best.per_hour} missions per hour{lead_time}.')


def _demand_in_words(study: Study, best: SizeResults) -> str:
    if study.site.demand.saturated:
        return ''
    if keeps_up(best):
        return f'This serves the demand of {best.requested:.0f} missions per hour.'
    return (f'The demand is {best.requested:.0f} missions per hour: '
            f'{100 * (1 - best.served):.0f} % of it is not served.')


def _more_robots_in_words(found: Sequence[SizeResults], best: SizeResults) -> str:
    """Returns what the next larger simulated fleet adds to the best one."""
    larger = next((size for size in found if size.robots > best.robots), None)
    if larger is None:
        return ('This is the largest simulated fleet: a larger one may serve more.'
                if len(found) > 1 else '')
    number = larger.robots - best.robots
    gain = 100 * (larger.per_hour.mean / max(best.per_hour.mean, 1e-9) - 1)
    subject = 'One more adds' if number == 1 else f'{_count(number, "more")} add'
    return f'{subject} {gain:.0f} %.' if gain >= 0.5 else f'{subject} nothing.'


def _waiting_in_words(study: Study, best: SizeResults) -> str:
    edges = list(waiting_by_drawn_edge(best, study.site.graph).items())[:2]
    if not edges or best.use[Use.WAITING] <= 0.01:
        return ''
    share = 100 * sum(part for _, part in edges)
    ids = ' and '.join(str(id) for id, _ in edges)
    subject, verb = ('edges', 'cause') if len(edges) > 1 else ('edge', 'causes')
    return (f'A robot spends {100 * best.use[Use.WAITING]:.0f} % of its time waiting; '
            f'{subject} {ids} {verb} {share:.0f} % of this waiting.')


def _bottleneck_in_words(best: SizeResults) -> str:
    found = bottlenecks_of(best)
    if not found:
        return ''
    first = found[0]
    if first.minutes < _FEW_MINUTES * best.robots:
        return 'No robot waits long for a station, a device or a charger.'
    told = (f'Of all stations, devices and chargers, {first.resource} is the bottleneck: robots '
            f'wait {_minutes(first.minutes)} per hour for it, mostly for {_main_reason(first)}, '
            f'and {100 * first.occupied:.0f} % of it is occupied')
    if len(found) == 1 or found[1].minutes < _FEW_MINUTES * best.robots:
        return f'{told}.'
    return f'{told}; for {found[1].resource} they wait {_minutes(found[1].minutes)}.'


def _main_reason(one: Bottleneck) -> str:
    return max(one.waiting, key=lambda why: one.waiting[why]).value


def _minutes(minutes: float) -> str:
    return f'{minutes:.0f} robot minutes' if minutes >= 9.5 else f'{minutes:.1f} robot minutes'


def _deadlines_in_words(best: SizeResults) -> str:
    deadlines, missed = _deadlines(best)
    if not deadlines:
        return ''
    return f'{missed} of {deadlines} deadlines were missed in the runs of this fleet.'


def _deadlines(size: SizeResults) -> Tuple[int, int]:
    """Returns the number of deadlines, and of those that were missed."""
    return sum(run.deadlines for run in size.runs), sum(run.missed for run in size.runs)


def _proposal_in_words(study: Study) -> str:
    good = [one for one in study.proposals if one.gain.mean - one.gain.half > 0.0]
    if not good:
        return ''
    return f'Best proposal: {good[0].what}. It adds {good[0].gain} missions per hour.'


def _failures_in_words(best: SizeResults) -> str:
    failed = sum(sum(run.failures.values()) for run in best.runs)
    return f'{_count(failed, "mission")} failed in the runs of this fleet.' if failed else ''


def _count(number: int, what: str) -> str:
    word = _WORDS[number] if number < len(_WORDS) else str(number)
    return f'{word[0].upper()}{word[1:]} {what}' + ('s' if number != 1 and what != 'more' else '')


def _time(seconds: float) -> str:
    if not math.isfinite(seconds):
        return '-'
    return f'{seconds:.0f} s' if seconds < 100.0 else f'{seconds / 60.0:.1f} minutes'


# -- the page -------------------------------------------------------------------------------------


def html(study: Study) -> str:
    """Returns the whole HTML page."""
    found = sizes(study.runs)
    parts = ['<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
             f'<title>{_TITLE}</title><style>{_STYLE}</style></head>',
             '<body><h1>How many robots does this site need?</h1>',
             f'<p class="words">{escape(in_words(study))}</p>', _warnings(study)]
    if found:
        best = knee(found)
        parts += [_throughput(study, found, best), _times(found), _use(found),
                  _waiting(study, best), _resources(best), _deadline_table(found),
                  _timetable_table(best),
                  _proposals(study), _needs(found), _planner(found),
                  _failures(found)]
    parts.append(_method(study))
    return '\n'.join(parts) + '</body></html>\n'


def _warnings(study: Study) -> str:
    told = []
    if study.ended_early:
        told.append('The simulation was ended early: the report covers only the completed runs.')
    told += [f'{run.robots} robots, seed {run.seed}: the run broke off. {run.trouble}'
             for run in study.runs if run.trouble]
    return ''.join(f'<p class="warning">{escape(one)}</p>' for one in told)


def _throughput(study: Study, found: Sequence[SizeResults], best: SizeResults) -> str:
    lines = [svg.Line('missions per hour, with 95 % band',
                      [(size.robots, size.per_hour.mean) for size in found],
                      [size.per_hour.half for size in found])]
    bounded, is_largest = not study.site.demand.saturated, best is found[-1]
    if bounded:
        lines.append(svg.Line('demand', [(size.robots, size.requested) for size in found]))
    rows = [(str(size.robots), str(size.per_hour), f'{size.per_hour.mean / size.robots:.1f}',
             f'{100 * size.served:.0f} %' if bounded else 'unlimited demand')
            for size in found]
    told = ('Each further robot adds 5 % or more: there is no knee in the simulated sizes.'
            if is_largest
            else f'The dashed line is the knee: {best.robots} robots. The knee is the smallest '
                 'fleet to which a further robot adds less than 5 %.')
    mark = math.nan if is_largest else best.robots
    return (f'<h2>Throughput</h2>{svg.chart(lines, "robots", "missions per hour", mark)}'
            + _table(('robots', 'missions per hour', 'per robot', 'share of the demand'), rows)
            + (f'<p>{told}</p>' if len(found) > 1 else ''))


def _times(found: Sequence[SizeResults]) -> str:
    lines = [svg.Line(f'{name}, {label}',
                      [(size.robots, quantile(getattr(size, field), share)) for size in found])
             for name, field in (('request to success', 'leads'), ('request to start', 'waits'))
             for share, label in ((0.5, 'p50'), (0.95, 'p95'))]
    rows = [(str(size.robots), *(_time(quantile(values, share))
                                 for values in (size.waits, size.leads) for share in (0.5, 0.95)))
            for size in found]
    return (f'<h2>Waiting and lead time</h2>{svg.chart(lines, "robots", "s")}'
            + _table(('robots', 'request to start, p50', 'p95', 'request to success, p50', 'p95'),
                     rows))


def _use(found: Sequence[SizeResults]) -> str:
    names = [use.value for use in Use]
    columns = {size.robots: [size.use[use] for use in Use] for size in found}
    return ("<h2>Where a robot's time goes</h2>"
            + svg.stacks(names, columns, 'robots', "share of the robots' time")
            + _table(('robots', *names), [
                (str(size.robots), *(f'{100 * size.use[use]:.1f} %' for use in Use))
                for size in found]))


def _waiting(study: Study, best: SizeResults) -> str:
    graph, edges = study.site.graph, waiting_by_drawn_edge(best, study.site.graph)
    told = list(edges)[:_TOLD_EDGES]
    rows = []
    for edge in told:
        causes = waiting_by_cause(best, graph.whole_edges((edge,)))
        rows.append((str(edge), f'{100 * edges[edge]:.1f} %', ', '.join(
            f'{cause.value} {100 * share:.0f} %' for cause, share in causes.items())))
    told_causes = ', '.join(f'{cause.value} {100 * share:.0f} %'
                       for cause, share in waiting_by_cause(best).items())
    return (f'<h2>Where {best.robots} robots wait</h2>'
            '<p>Waiting counts at the edge that the robot wants to drive next. Causes of all '
            f'waiting: {escape(told_causes or "none")}.</p>'
            + svg.site_map(graph, waiting_by_edge(best), told)
            + _table(('edge', 'share of all waiting', 'causes'), rows))


def _resources(best: SizeResults) -> str:
    rows = [(str(one.resource), str(one.resource.capacity), f'{100 * one.occupied:.0f} %',
             f'{one.minutes:.1f}', *(f'{one.waiting[why]:.1f}' for why in HoldUp))
            for one in bottlenecks_of(best)]
    if not rows:
        return ''
    return (f'<h2>Stations, devices and chargers, with {best.robots} robots</h2>'
            '<p>Occupied: share of the capacity that robots claim, on their way there included. '
            'Waiting: robot minutes per hour.</p>'
            + _table(('', 'capacity', 'occupied', 'waiting', *(
                f'for {why.value}' for why in HoldUp)), rows))


def _deadline_table(found: Sequence[SizeResults]) -> str:
    rows = [(str(size.robots), str(deadlines), str(missed), f'{100 * missed / deadlines:.1f} %')
            for size in found for deadlines, missed in (_deadlines(size),) if deadlines]
    return '<h2>Deadlines</h2>' + _table(('robots', 'deadlines', 'missed', 'share'),
                                         rows) if rows else ''


def _timetable_table(best: SizeResults) -> str:
    whole: Dict[str, TimetableUse] = {}
    for run in best.runs:
        for name, use in run.timetables.items():
            whole.setdefault(name, TimetableUse()).add(use)
    rows = [(name, str(use.requested), str(use.succeeded),
             *(_time(quantile(use.leads, share)) if use.leads else '-' for share in (0.5, 0.95)),
             str(use.deadlines), str(use.missed)) for name, use in whole.items()]
    return (f'<h2>Timetables, with {best.robots} robots</h2>' + _table(
        ('', 'missions', 'done', 'request to success, p50', 'p95', 'deadlines', 'missed'), rows)
            ) if rows else ''


def _proposals(study: Study) -> str:
    if not study.proposals:
        return ''
    return '<h2>Proposals</h2><p>Each change was simulated with the same seeds.</p>' + _table(
        ('change', 'additional missions per hour, 95 % band', 'changed graph'),
        [(one.what, f'{one.gain.mean:+.1f} ± {one.gain.half:.1f}', one.file)
         for one in study.proposals])


def _needs(found: Sequence[SizeResults]) -> str:
    return '<h2>Docks and parking vertices in use</h2>' + _table(
        ('robots', 'most robots at docks at the same time',
         'most idle robots elsewhere at the same time', 'km per hour and robot'),
        [(str(size.robots), str(max(run.docks for run in size.runs)),
          str(max(run.parked for run in size.runs)),
          f'{_mean(3.6 * run.travelled / run.simulated / run.robots for run in size.runs):.2f}')
         for size in found])


def _planner(found: Sequence[SizeResults]) -> str:
    rows = []
    for size in found:
        times = [1e3 * one for run in size.runs for one in run.planning]
        rows.append((str(size.robots), f'{len(times) / len(size.runs):.0f}',
                     *(f'{quantile(times, share):.0f} ms' for share in (0.5, 0.95, 1.0)),
                     f'{_mean(run.speed for run in size.runs):.0f} x'))
    return '<h2>The planner, on this computer</h2>' + _table(
        ('robots', 'plans per run', 'time of a plan, p50', 'p95', 'longest',
         'times real time, per core'), rows)


def _failures(found: Sequence[SizeResults]) -> str:
    rows = []
    for size in found:
        why: Dict[str, int] = {}
        for run in size.runs:
            for reason, count in run.failures.items():
                why[reason] = why.get(reason, 0) + count
        rows += [(str(size.robots), str(count), reason) for reason, count in why.items()]
    return '<h2>Failures</h2>' + (
        _table(('robots', 'missions', 'reason'), rows) if rows else '<p>No mission failed.</p>')


def _method(study: Study) -> str:
    delays = study.site.delays
    seeds = len({run.seed for run in study.runs})
    return (
        f'<h2>Method</h2><p>{len(study.runs)} runs of {study.hours:g} h each were simulated with '
        f'{seeds} seeds, by the supervisor, interlocking and planner of the fleet manager on a '
        'virtual clock. The first ten minutes of a run, at most a tenth of it, do not count. The '
        f'planner answers after {study.site.latency:g} s. Each edge takes up to {delays.slower:g} '
        'times its shortest driving time. On average, a robot stops once in '
        f'{delays.stall.every:g} s of driving for about {delays.stall.seconds:g} s by itself, and '
        f'once in {delays.people.every:g} s for about {delays.people.seconds:g} s because a '
        'person is in the way.</p>'
        f'<p><code>{escape(study.command)}</code></p>')


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    def line(cells: Sequence[str], tag: str) -> str:
        return '<tr>' + ''.join(f'<{tag}>{escape(cell)}</{tag}>' for cell in cells) + '</tr>'
    return ('<table>' + line(head, 'th') + ''.join(line(row, 'td') for row in rows) + '</table>')


def _mean(values: Iterable[float]) -> float:
    listed = list(values)
    return sum(listed) / len(listed) if listed else 0.0


# -- tables ---------------------------------------------------------------------------------------


Rows = List[Tuple[object, ...]]


def _tables(study: Study) -> Dict[str, Rows]:
    """Returns the rows of each CSV file by its name, the header first; times are in s."""
    graph = study.site.graph
    return {
        'runs.csv': [_RUN_COLUMNS, *map(_run_row, study.runs)],
        'waiting.csv': [('robots', 'seed', 'edge', 'cause', 'robot_s', 'drawn_edge'),
                        *_of_each(study, lambda run: _waiting_rows(run, graph))],
        'missions.csv': [('robots', 'seed', 'what', 'seconds'), *_of_each(study, _mission_rows)],
        'resources.csv': [('robots', 'seed', 'resource', 'capacity', 'claimed_robot_s',
                           'waiting_for', 'robot_s'), *_of_each(study, _resource_rows)],
        'timetables.csv': [('robots', 'seed', 'timetable', 'missions', 'done', 'lead_p50',
                            'lead_p95', 'deadlines', 'missed'), *_of_each(study, _timetable_rows)],
        'failures.csv': [('robots', 'seed', 'missions', 'why'), *_of_each(study, _failure_rows)],
        'proposals.csv': [('change', 'gain_per_hour', 'half_band', 'graph'), *(
            (one.what, f'{one.gain.mean:.2f}', f'{one.gain.half:.2f}', one.file)
            for one in study.proposals)]}


def _of_each(study: Study, rows: Callable[[Figures], Rows]) -> Rows:
    """The rows of all runs. Each begins with the size and the seed of its run."""
    return [(run.robots, run.seed, *row) for run in study.runs for row in rows(run)]


_RUN_COLUMNS: Tuple[object, ...] = (
    'robots', 'seed', 'measured_s', 'requested', 'succeeded', 'per_hour', 'open_at_end', 'failed',
    'wait_p50', 'wait_p95', 'lead_p50', 'lead_p95',
    *(f'{use.name.lower()}_robot_s' for use in Use), 'docks', 'parked', 'travelled_m', 'deadlines',
    'missed', 'plans', 'plan_p50', 'plan_p95', 'plan_longest', 'world_cpu_s', 'supervisor_cpu_s',
    'planner_cpu_s', 'times_real_time', 'trouble')


def _run_row(run: Figures) -> Tuple[object, ...]:
    return (run.robots, run.seed, f'{run.seconds:.1f}', run.requested, run.succeeded,
            f'{run.per_hour:.2f}', run.open_at_end, sum(run.failures.values()),
            *(f'{quantile(values, share):.2f}' for values in (run.waits, run.leads)
              for share in (0.5, 0.95)),
            *(f'{run.use[use]:.0f}' for use in Use), run.docks, run.parked,
            f'{run.travelled:.0f}', run.deadlines, run.missed, len(run.planning),
            *(f'{quantile(run.planning, share):.4f}' for share in (0.5, 0.95, 1.0)),
            *(f'{seconds:.2f}' for seconds in run.spent), f'{run.speed:.1f}', run.trouble)


def _waiting_rows(run: Figures, graph: Graph) -> Rows:
    return [(edge, cause.value, f'{seconds:.0f}', _drawn(graph, edge))
            for (edge, cause), seconds in sorted(run.waiting.items(), key=_by_edge)]


def _mission_rows(run: Figures) -> Rows:
    return [(what, f'{one:.2f}') for what, times in (
        ('request to start', run.waits), ('request to success', run.leads)) for one in times]


def _resource_rows(run: Figures) -> Rows:
    return [(use.resource, use.resource.capacity, f'{use.claimed:.0f}', why.value, f'{wait:.0f}')
            for use in run.resources.values() for why, wait in use.waiting.items()]


def _timetable_rows(run: Figures) -> Rows:
    return [(name, use.requested, use.succeeded,
             *(f'{quantile(use.leads, share):.2f}' for share in (0.5, 0.95)), use.deadlines,
             use.missed) for name, use in run.timetables.items()]


def _failure_rows(run: Figures) -> Rows:
    return [(count, why) for why, count in run.failures.items()]


def _drawn(graph: Graph, edge: int) -> int:
    return graph.edges[edge].drawn_id if edge in graph.edges else edge


def _by_edge(item: Tuple[Tuple[int, WaitingCause], float]) -> Tuple[int, str]:
    (edge, cause), _ = item
    return edge, cause.value
