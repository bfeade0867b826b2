"""The command `simulate_jobs`: it plays a day of jobs against a simulated fleet, without ROS.

Exit status:
- 0: The day was played, and the job server broke no promise (see `judge`).
- 1: The input is wrong; stderr has one sentence.
- 2: The job server broke a promise; the output says which.
- 130: Ctrl-C.
"""
from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Dict, NoReturn, Optional, Sequence, Set

from file_replacement import replace_file
from fleet_core.files.errors import FileError
from fleet_core.files.fleet_file import load_fleet
from fleet_core.files.robot_settings import load_settings
from fleet_core.files.work_file import load_work
from fleet_core.work.site_work import SiteWork
from fleet_simulation.demand import Demand
from fleet_simulation.demand_file import Wanted
from fleet_simulation.driven_robot import Delays
from fleet_simulation.site import WrongSite, site_of
from omron_jobs.day.day_file import load_day
from omron_jobs.day.day_report import as_csv, in_words
from omron_jobs.day.day_run import DayRun
from omron_jobs.fleet.missions import goals_of
from trajectory_graph import GraphError, load_graph


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(1, f'{self.prog}: {message}; see {self.prog} --help.\n')


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog='simulate_jobs',
                     description='Plays a day of jobs of a warehouse program against a simulated '
                                 'fleet, and reports waiting times and late jobs. It runs the job '
                                 'server, supervisor, interlocking and planner.')
    parser.add_argument('day', metavar='DAY', help='the jobs: on each line a time and a command')
    parser.add_argument('--graph', required=True, help='trajectory graph (YAML)')
    parser.add_argument('--fleet', required=True, help='fleet file (YAML)')
    parser.add_argument('--work', help='stations, devices and the steps of jobs (YAML)')
    parser.add_argument('--robots', type=_count, metavar='N', default=0,
                        help='fleet size (default: the number of robots in the fleet file)')
    parser.add_argument('--late', type=_count, metavar='MIN', default=20,
                        help='minutes after which a job is late (20)')
    parser.add_argument('--seed', type=_count, default=1, help='draws delays and batteries (1)')
    parser.add_argument('--csv', type=Path, metavar='FILE', help='write a row for each job')
    return parser


def _count(text: str) -> int:
    if not text.isdigit() or not 1 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f'{text!r} is not a whole number from 1 to 1000')
    return int(text)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    options = _parser().parse_args(arguments)
    try:
        graph, fleet = load_graph(options.graph), load_fleet(options.fleet)
        work = load_work(options.work, graph) if options.work else SiteWork()
        site = site_of(graph, fleet, load_settings(options.fleet),
                       Wanted(Demand(), Delays(), {}, {}, work))
        lines = load_day(options.day, _names(goals_of(graph.vertices.values())))
        run = DayRun(site, options.robots or max(len(fleet.robots), 1), options.seed, lines)
    except (GraphError, FileError, WrongSite) as error:
        print(error, file=sys.stderr)
        return 1
    try:
        day = run.play()
        if options.csv is not None:
            replace_file(options.csv, as_csv(day))
    except KeyboardInterrupt:
        print('The day was not played to its end: there is no report.', file=sys.stderr)
        return 130
    except OSError as error:
        print(f'{options.csv} cannot be written: {error.strerror}.', file=sys.stderr)
        return 1
    print(in_words(day, 60.0 * options.late))
    return 2 if day.wrong else 0


def _names(goals: Dict[str, int]) -> Set[str]:
    """Returns all words that may name these goals."""
    return {*goals, *map(str, goals.values())}
