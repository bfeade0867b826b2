"""The command `simulate_fleet`: it finds how many robots a site needs, without a ROS master.

Exit status:
- 0: The report is written.
- 1: The input is wrong; stderr has one sentence.
- 3: Ctrl-C; the report covers the completed runs.
- 130: Ctrl-C before any run was completed.
"""
from __future__ import annotations

import argparse
import math
import multiprocessing
import shlex
import sys
from dataclasses import replace
from datetime import datetime
from math import inf
from pathlib import Path
from typing import Dict, FrozenSet, List, NoReturn, Optional, Sequence, Tuple

from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_core.files.work_file import load_work
from fleet_core.supervision.load_places import too_near
from fleet_core.work.site_work import SiteWork
from fleet_core.work.timetables import DAY, DAYS, minute_of_day
from fleet_simulation.batch import Done, Job, ProgressBar, run_all
from fleet_simulation.demand_file import load_demand
from fleet_simulation.figures import Figures
from fleet_simulation.proposals import Proposal, proposals
from fleet_simulation.report import is_free, write
from fleet_simulation.site import OrderPolicy, StudiedSite, WrongSite, site_of, with_docks
from fleet_simulation.statistics import band, knee, sizes, waiting_by_edge
from fleet_simulation.study import InputFiles, Proposed, Study
from fleet_simulation.walls import NO_WALLS, load_walls
from fleet_simulation.words import in_words
from trajectory_graph import Graph, GraphError, load_graph, save_graph, split_edges

_PROPOSED_EDGES = 4


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(1, f'{self.prog}: {message}; see {self.prog} --help.\n')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    options = _parser().parse_args(words)
    try:
        if not is_free(options.output):
            raise WrongSite(f'{options.output} has files that are no earlier report; they could be '
                            'overwritten: name a new or empty folder with --output.')
        made, site = datetime.now(), _site(options)
        walls = load_walls(options.map) if options.map else NO_WALLS
        counts = options.robots or (max(len(site.fleet.robots), 1),)
        for count in counts:
            site.robots(count)
        for one in too_near(site.work, site.fleet, site.graph):
            print(f'{options.work}: {one.text}.', file=sys.stderr)
        runs, ended = _runs(site, counts, options)
        if not runs:
            print('No run was completed: there is no report.', file=sys.stderr)
            return 130
        proposed: List[Proposed] = []
        if options.proposals and not ended and sizes(runs):
            proposed, ended = _try_proposals(site, runs, options)
        study = Study(site, _files(options), made, runs, options.hours,
                      'simulate_fleet ' + shlex.join(words), ended, proposed, walls)
        path = write(study, options.output)
    except (GraphError, FileError, WrongSite) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(f'{options.output} cannot be written: {error.strerror}.', file=sys.stderr)
        return 1
    print(in_words(study))
    print(path)
    return 3 if ended else 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog='simulate_fleet',
                     description='Simulates fleets of several sizes on a site, and reports how '
                                 'many missions each serves. It runs the supervisor, interlocking '
                                 'and planner of the fleet manager.')
    parser.add_argument('--graph', required=True, help='trajectory graph (YAML)')
    parser.add_argument('--fleet', required=True, help='robot types and robots (YAML)')
    parser.add_argument('--demand', required=True, help='missions (YAML)')
    parser.add_argument('--work', help='stations, devices and templates of missions (YAML)')
    parser.add_argument('--map', help='.map file whose walls the report draws')
    parser.add_argument('--output', required=True, type=Path, help='folder for the report')
    parser.add_argument('--robots', type=_counts, metavar='N|N..M|N,M', default=(),
                        help='fleet sizes (default: the number of robots in the fleet file)')
    parser.add_argument('--hours', type=_positive, default=8.0,
                        help='virtual hours of each run (8)')
    parser.add_argument('--begin', type=_moment, default=_moment('mon 06:00'),
                        metavar='DAY HH:MM', help='day and time at which each run begins, for the '
                                                  'timetables of the work file (mon 06:00)')
    parser.add_argument('--seeds', type=_whole, default=5, help='runs of each size (5)')
    parser.add_argument('--longest-edge', type=_positive, metavar='M',
                        help='cut edges longer than M metres into sections, as fleet_launch does')
    parser.add_argument('--latency', type=_positive, default=0.1, metavar='S',
                        help='virtual s until the planner answers (0.1)')
    parser.add_argument('--rounds', type=int, default=0,
                        help='rounds in which the planner improves each plan (0)')
    parser.add_argument('--order', type=OrderPolicy, choices=list(OrderPolicy),
                        default=OrderPolicy.FIXED,
                        metavar='|'.join(order.value for order in OrderPolicy),
                        help='how the order of robots on shared places changes while robots are '
                             'late (fixed)')
    parser.add_argument('--proposals', type=int, default=0, metavar='N',
                        help='try at most N changes of the graph, on the same seeds (0)')
    parser.add_argument('--jobs', type=_whole, default=multiprocessing.cpu_count(),
                        help='runs at the same time (one per core)')
    return parser


def _counts(text: str) -> Tuple[int, ...]:
    try:
        if '..' in text:
            first, last = map(int, text.split('..'))
            found = tuple(range(first, last + 1))
        else:
            found = tuple(sorted(set(map(int, text.split(',')))))
    except ValueError:
        found = ()
    if not found or found[0] < 1 or found[-1] > 1000:
        raise argparse.ArgumentTypeError(f'{text!r} is not a number of robots from 1 to 1000: give '
                                         'for example 6, 2..20 or 2,4,8')
    return found


def _moment(text: str) -> int:
    """Converts a text such as `mon 06:00` to minutes since the beginning of Monday."""
    day, _, time = text.partition(' ')
    try:
        return DAYS.index(day) * DAY + minute_of_day(time)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is not a day and a time, such as "mon 06:00"; '
                                         f'the days are: {", ".join(DAYS)}') from None


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < inf:
        raise argparse.ArgumentTypeError(f'{text!r} is not a number above 0')
    return value


def _whole(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f'{text!r} is not a whole number above 0')
    return int(text)


def _site(options: argparse.Namespace, graph: Optional[Graph] = None,
          docks: FrozenSet[int] = frozenset()) -> StudiedSite:
    """Returns the site that the files describe.

    graph -- replaces the graph in the graph file; None: the graph file is used
    docks -- ids of docks to add to those of the fleet file
    """
    if graph is None:
        graph = load_graph(options.graph)
        if options.longest_edge:
            graph = split_edges(graph, options.longest_edge)
    fleet = with_docks(load_fleet(options.fleet), docks)
    work = load_work(options.work, graph, fleet) if options.work else SiteWork()
    site = site_of(graph, fleet, load_settings(options.fleet),
                   load_demand(options.demand, graph, work), options.latency, options.rounds)
    return replace(site, order=options.order, begin=options.begin)


def _files(options: argparse.Namespace) -> InputFiles:
    return InputFiles(*(Path(name).name if name else '' for name in (
        options.graph, options.fleet, options.demand, options.work, options.map)))


def _runs(site: StudiedSite, counts: Sequence[int],
          options: argparse.Namespace) -> Tuple[List[Figures], bool]:
    jobs = [Job(0, count, seed, options.hours)
            for seed in range(1, options.seeds + 1) for count in counts]
    done, ended = run_all([site], jobs, options.jobs, ProgressBar('runs'))
    return [figures for _, figures in done], ended


def _try_proposals(site: StudiedSite, runs: Sequence[Figures],
                   options: argparse.Namespace) -> Tuple[List[Proposed], bool]:
    """Simulates changes of the graph, with the fleet size at the knee and the same seeds.

    Returns the changes, the highest gain first, and whether Ctrl-C ended the batch.
    """
    best = knee(sizes(runs))
    room = 2.0 * max(kind.reach for kind in site.fleet.types) + site.fleet.clearance
    edges = list(waiting_by_edge(best))[:_PROPOSED_EDGES]
    tried: List[Tuple[Proposal, StudiedSite]] = []
    docks_in_use = max(run.docks for run in best.runs)
    for proposal in proposals(site.graph, edges, room, docks_in_use):
        try:
            changed = _site(options, proposal.graph, proposal.docks)
            changed.robots(best.robots)
        except (WrongSite, FileError):
            continue  # with this change the demand cannot be served or the robots cannot be parked
        same = site.robots(best.robots)
        tried.append((proposal, replace(changed, starts=site.starts)
                      if all(one.vertex in changed.graph.vertices for one in same.values())
                      else changed))
        if len(tried) == options.proposals:
            break
    if not tried:
        return [], False
    jobs = [Job(number, best.robots, run.seed, options.hours)
            for run in best.runs for number in range(len(tried))]
    done, ended = run_all([changed for _, changed in tried], jobs, options.jobs,
                          ProgressBar('proposals'))
    return _ranked(tried, done, {run.seed: run.per_hour for run in best.runs},
                   options.output), ended


def _ranked(tried: Sequence[Tuple[Proposal, StudiedSite]], done: Sequence[Done],
            before: Dict[int, float], folder: Path) -> List[Proposed]:
    folder.mkdir(parents=True, exist_ok=True)
    found = []
    for number, (proposal, _) in enumerate(tried):
        gains = [figures.per_hour - before[job.seed] for job, figures in done
                 if job.site == number and not figures.trouble]
        if gains:
            name = f'{proposal.name}.yaml'
            save_graph(proposal.graph, folder / name)
            found.append(Proposed(proposal.what, band(gains), name))
    return sorted(found, key=lambda one: -one.gain.mean)
