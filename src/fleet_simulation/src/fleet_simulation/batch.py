"""Executes many simulation runs on all cores, with a progress display.

Ctrl-C ends the batch; the results of the completed runs are kept.
"""
from __future__ import annotations

import multiprocessing
import signal
import sys
import time
from typing import Callable, List, NamedTuple, Sequence, Tuple

from fleet_simulation.figures import Figures
from fleet_simulation.simulation import simulate
from fleet_simulation.site import StudiedSite
from node_program.inert_text import return_to_line_begin


class Job(NamedTuple):
    """One run: `site` is the index of its site in the batch, from 0; `hours` are virtual hours."""

    site: int
    robots: int
    seed: int
    hours: float


Done = Tuple[Job, Figures]
_sites: Tuple[StudiedSite, ...] = ()


def _begin(sites: Tuple[StudiedSite, ...]) -> None:
    global _sites
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # on Ctrl-C, the batch itself ends its workers
    _sites = sites


def _work(job: Job) -> Done:
    return job, simulate(_sites[job.site], job.robots, job.seed, job.hours)


def run_all(sites: Sequence[StudiedSite], jobs: Sequence[Job], processes: int,
            tell: Callable[[int, int], None]) -> Tuple[List[Done], bool]:
    """Returns the completed runs in the order of the jobs, and whether Ctrl-C ended the batch.

    processes -- largest number of runs at the same time
    tell      -- called after each run, with the numbers of completed runs and of all runs
    """
    done: List[Done] = []
    pool = multiprocessing.Pool(min(processes, len(jobs)), _begin, (tuple(sites),))
    try:
        tell(0, len(jobs))
        for one in pool.imap_unordered(_work, jobs):
            done.append(one)
            tell(len(done), len(jobs))
        is_whole = True
    except KeyboardInterrupt:
        is_whole = False
    finally:
        pool.terminate()
        pool.join()
    order = {job: number for number, job in enumerate(jobs)}
    return sorted(done, key=lambda one: order[one[0]]), not is_whole


class ProgressBar:
    """Shows progress on stderr: a bar on a terminal, otherwise one line per tenth of the runs."""

    def __init__(self, what: str) -> None:
        self._what, self._begun, self._tenth = what, time.monotonic(), -1

    def __call__(self, done: int, whole: int) -> None:
        """Shows that `done` of `whole` runs are completed."""
        spent = time.monotonic() - self._begun
        left = f'{spent / done * (whole - done):.0f} s to go' if done else ''
        if sys.stderr.isatty():
            bar = '#' * (30 * done // whole)
            return_to_line_begin(sys.stderr)
            print(f'{self._what} [{bar:<30}] {done}/{whole} {left:<20}', end='', file=sys.stderr,
                  flush=True)
            if done == whole:
                print(file=sys.stderr)
        elif 10 * done // whole > self._tenth:
            self._tenth = 10 * done // whole
            print(f'{self._what}: {done} of {whole} {left}', file=sys.stderr)
