"""Writes the report: one HTML file that needs no network, and CSV files with all figures."""
from __future__ import annotations

import csv
import io
import math
import os
from html import escape
from pathlib import Path
from typing import Callable, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from file_replacement import replace_file
from fleet_simulation import svg
from fleet_simulation.demand import Demand, Flow, Saturated
from fleet_simulation.figures import Figures, TimetableUse, Use, WaitingCause
from fleet_simulation.hold_ups import HoldUp
from fleet_simulation.site_map import site_map
from fleet_simulation.statistics import (
    KEPT_UP,
    Side,
    SizeResults,
    bottlenecks_of,
    gain,
    knee,
    quantile,
    served_share,
    sizes,
    waiting_by_cause,
    waiting_by_drawn_edge,
    waiting_by_edge,
)
from fleet_simulation.study import Study
from fleet_simulation.words import deadlines_of, in_words, percent, several, time_in_words
from node_program.inert_text import cell
from trajectory_graph import Graph
from trajectory_graph.drawn_names import drawn_ids, size_of

REPORT = 'report.html'
_TITLE = 'How many robots does this site need?'
_TOLD_EDGES = 10
_SERVES = {Side.ABOVE: 'yes', Side.BELOW: 'no', Side.UNDECIDED: Side.UNDECIDED.value}
_VERDICTS = {Side.ABOVE: 'better', Side.BELOW: 'worse', Side.UNDECIDED: Side.UNDECIDED.value}
_RULE = ('± is half of the 95 % confidence interval (Student) of the mean over the seeds. Two '
         'fleets, and two graphs, are compared seed by seed. A difference is decided if its '
         'interval does not contain zero, and a fleet serves the demand if its interval lies '
         f'above {100 * KEPT_UP:.0f} % of the missions. Otherwise the report says "'
         f'{Side.UNDECIDED.value}".')
_STYLE = '''
body { font: 15px/1.45 sans-serif; max-width: 960px; margin: 2em auto; padding: 0 1em;
       color: #222; }
.wide { overflow-x: auto; }
svg { font: 12px sans-serif; }
table { border-collapse: collapse; margin: 0.6em 0; }
th, td { border-bottom: 1px solid #ddd; padding: 3px 10px; text-align: right; }
th:first-child, td:first-child { text-align: left; }
.words { font-size: 1.15em; background: #f2f5f8; padding: 0.8em 1em; border-radius: 6px; }
.head th { white-space: nowrap; vertical-align: top; }
.head td { text-align: left; }
.warning { background: #fff0e8; padding: 0.6em 1em; border-radius: 6px; }
'''


def write(study: Study, folder: Path) -> Path:
    """Writes all files into the folder; returns the path of the HTML file.

    A new file replaces an older file only when the new file is complete.
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
    """Returns whether a report may be written here: the folder is new, empty, or has an old report.
    """
    try:
        names = os.listdir(folder)
    except FileNotFoundError:
        return True
    if REPORT in names:
        return _TITLE in (folder / REPORT).read_text(encoding='utf-8', errors='replace')
    return not names


# -- the page -------------------------------------------------------------------------------------


def html(study: Study) -> str:
    """Returns the whole HTML page."""
    found = sizes(study.runs)
    parts = ['<!DOCTYPE html><html lang="en"><head><meta charset="utf-8">',
             '<meta name="viewport" content="width=device-width, initial-scale=1">',
             f'<title>{_TITLE}</title><style>{_STYLE}</style></head>',
             f'<body><h1>{_TITLE}</h1>', _head(study),
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


def _head(study: Study) -> str:
    """Returns the table of what was simulated: site, date, demand, fleet, runs."""
    site, files = study.site, study.files
    places = np.array([vertex.position for vertex in site.graph.vertices.values()])
    width, tall = np.ptp(places, axis=0).tolist()
    extent = f'{width:.0f} m x {tall:.0f} m'
    rows = [('Site', f'{files.graph}: {size_of(site.graph)}, {extent}')]
    if files.work:
        work = site.work
        rows.append(('Work', f'{files.work}: {several(len(work.stations), "station")}, '
                             f'{several(len(work.devices), "device")}, '
                             f'{several(len(work.templates), "template")}'))
    if files.walls:
        rows.append(('Walls', files.walls))
    sizes_run = sorted({run.robots for run in study.runs})
    seeds = len({run.seed for run in study.runs})
    rows += [
        ('Date', f'{study.made:%Y-%m-%d %H:%M}'),
        ('Demand', f'{files.demand}: ' + '; '.join(_flows(site.demand, study.hours))),
        ('Fleet', f'{files.fleet}: ' + ', '.join(kind.name for kind in site.fleet.types)
         + f'; simulated with {_listed(sizes_run)} {"robot" if sizes_run == [1] else "robots"}'),
        ('Runs', f'{several(seeds, "run")} of {study.hours:g} h for each size of the fleet, each '
                 'with its own seed')]
    return '<table class="head">' + ''.join(
        f'<tr><th>{name}</th><td>{escape(what)}</td></tr>' for name, what in rows) + '</table>'


def _flows(demand: Demand, hours: float) -> Iterator[str]:
    """Yields each flow with its missions per hour."""
    for flow in demand.flows:
        where = flow.template if not isinstance(flow, Flow) else ''.join(
            (f'from {_places(flow.sources)} ' if flow.sources else '',
             f'to {_places(flow.targets)}'))
        name = f'{flow.name} ({where})' if flow.name else where
        if isinstance(flow.arrivals, Saturated):
            yield f'{name}, as many as the fleet serves'
        else:
            number = sum(shift.per_hour * max(min(shift.end, hours) - shift.begin, 0.0)
                         for shift in flow.arrivals) / hours
            yield f'{name}, {number:.3g} per hour'
    if demand.recorded:
        yield several(len(demand.recorded), 'recorded mission')


def _places(ids: Sequence[int]) -> str:
    return f'vertex {ids[0]}' if len(ids) == 1 else f'one of {len(ids)} vertices'


def _listed(numbers: Sequence[int]) -> str:
    if len(numbers) > 2 and numbers[-1] - numbers[0] == len(numbers) - 1:
        return f'{numbers[0]} to {numbers[-1]}'
    return ', '.join(map(str, numbers))


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
             _against(size, before),
             *((percent(served_share(size)), _SERVES[served_share(size).side(KEPT_UP)])
               if bounded else ()))
            for before, size in zip([None, *found], found)]
    told = ('Each further robot adds 5 % or more: there is no knee in the simulated sizes.'
            if is_largest
            else f'The dashed line is the knee: {best.robots} robots. The knee is the smallest '
                 'fleet to which a further robot adds less than 5 %.')
    mark = math.nan if is_largest else best.robots
    return ('<h2>Throughput</h2>'
            + _wide(svg.chart(lines, 'robots', 'missions per hour', mark))
            + _table(('robots', 'missions per hour', 'per robot', 'against the row before',
                      *(('share of the demand', 'serves it') if bounded else ())), rows)
            + (f'<p>{told}</p>' if len(found) > 1 else '') + f'<p>{_RULE}</p>')


def _against(size: SizeResults, before: Optional[SizeResults]) -> str:
    """Returns the change of throughput against the next smaller fleet, and its significance."""
    if before is None:
        return ''
    more = gain(before, size)
    sign = '+' if more.mean >= 0.0 else ''
    undecided = f', {Side.UNDECIDED.value}' if more.side() is Side.UNDECIDED else ''
    return f'{sign}{percent(more)}{undecided}'


def _times(found: Sequence[SizeResults]) -> str:
    lines = [svg.Line(f'{name}, {label}',
                      [(size.robots, quantile(getattr(size, field), share)) for size in found])
             for name, field in (('request to success', 'leads'), ('request to start', 'waits'))
             for share, label in ((0.5, 'p50'), (0.95, 'p95'))]
    rows = [(str(size.robots), *(time_in_words(quantile(values, share))
                                 for values in (size.waits, size.leads) for share in (0.5, 0.95)))
            for size in found]
    return (f'<h2>Waiting and lead time</h2>{_wide(svg.chart(lines, "robots", "s"))}'
            + _table(('robots', 'request to start, p50', 'p95', 'request to success, p50', 'p95'),
                     rows))


def _use(found: Sequence[SizeResults]) -> str:
    names = [use.value for use in Use]
    columns = {size.robots: [size.use[use] for use in Use] for size in found}
    return ("<h2>Where a robot's time goes</h2>"
            + _wide(svg.stacks(names, columns, 'robots', "share of the robots' time"))
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
            + _wide(site_map(graph, waiting_by_edge(best), told, study.site.work, study.walls))
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
            for size in found for deadlines, missed in (deadlines_of(size),) if deadlines]
    return '<h2>Deadlines</h2>' + _table(('robots', 'deadlines', 'missed', 'share'),
                                         rows) if rows else ''


def _timetable_table(best: SizeResults) -> str:
    whole: Dict[str, TimetableUse] = {}
    for run in best.runs:
        for name, use in run.timetables.items():
            whole.setdefault(name, TimetableUse()).add(use)
    rows = [(name, str(use.requested), str(use.succeeded),
             *(time_in_words(quantile(use.leads, share)) if use.leads else '-'
               for share in (0.5, 0.95)),
             str(use.deadlines), str(use.missed)) for name, use in whole.items()]
    return (f'<h2>Timetables, with {best.robots} robots</h2>' + _table(
        ('', 'missions', 'done', 'request to success, p50', 'p95', 'deadlines', 'missed'), rows)
            ) if rows else ''


def _proposals(study: Study) -> str:
    if not study.proposals:
        return ''
    return '<h2>Proposals</h2><p>Each change was simulated with the same seeds.</p>' + _table(
        ('change', 'additional missions per hour, 95 % band', 'verdict', 'changed graph'),
        [(one.what, f'{one.gain.mean:+.1f}' + (
            f' ± {one.gain.half:.1f}' if one.gain.half < math.inf else ''),
          _VERDICTS[one.gain.side()], one.file) for one in study.proposals])


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
    return _wide('<table>' + line(head, 'th') + ''.join(line(row, 'td') for row in rows)
                 + '</table>')


def _wide(part: str) -> str:
    """Returns a part of the page that can be scrolled sideways where the window is narrow."""
    return f'<div class="wide">{part}</div>'


def _mean(values: Iterable[float]) -> float:
    listed = list(values)
    return sum(listed) / len(listed) if listed else 0.0


# -- tables ---------------------------------------------------------------------------------------


Rows = List[Tuple[object, ...]]


def _tables(study: Study) -> Dict[str, Rows]:
    """Returns the rows of each CSV file, header first; the keys are the file names. Times are in s.
    """
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
    """Returns the rows of all runs. Each row begins with the fleet size and the seed of its run."""
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
    return [(edge, cause.value, f'{seconds:.0f}', *drawn_ids(graph, (edge,)))
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


def _by_edge(item: Tuple[Tuple[int, WaitingCause], float]) -> Tuple[int, str]:
    (edge, cause), _ = item
    return edge, cause.value
