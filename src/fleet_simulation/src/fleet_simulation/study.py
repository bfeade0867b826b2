"""The content of a report: the simulated site, its input files, the runs and the proposals."""
from __future__ import annotations

from datetime import datetime
from typing import NamedTuple, Sequence

from fleet_simulation.figures import Figures
from fleet_simulation.site import StudiedSite
from fleet_simulation.statistics import Band
from fleet_simulation.walls import NO_WALLS, Walls


class Proposed(NamedTuple):
    """A simulated change of the graph.

    what -- the change in words, an imperative such as `cut edge 5`
    gain -- additional missions per hour
    file -- name of the file with the changed graph
    """

    what: str
    gain: Band
    file: str


class InputFiles(NamedTuple):
    """The names of the files that describe the site; `work` and `walls` may be empty."""

    graph: str
    fleet: str
    demand: str
    work: str = ''
    walls: str = ''


class Study(NamedTuple):
    """All that a report shows.

    made        -- when the study began, in local time
    hours       -- virtual hours of each run
    command     -- the command line that requested the study
    ended_early -- whether Ctrl-C ended the study before all runs were completed
    proposals   -- simulated changes of the graph, the highest gain first
    """

    site: StudiedSite
    files: InputFiles
    made: datetime
    runs: Sequence[Figures]
    hours: float
    command: str
    ended_early: bool = False
    proposals: Sequence[Proposed] = ()
    walls: Walls = NO_WALLS
