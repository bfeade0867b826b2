"""All jobs that are kept, with several indices for quick queries.

Each index is updated when a job changes. A server may have a thousand jobs, so a new status of one
job must not require a search through all of them.
"""
from __future__ import annotations

from typing import Callable, Dict, Iterable, List, Optional, Sequence, Set

from omron_jobs.core.jobs import QueuedJob


class JobShelf:
    """The jobs, by their missions.

    on_change -- called with the mission of each job that is new, has changed or was forgotten
    """

    def __init__(self, jobs: Iterable[QueuedJob]) -> None:
        self.on_change: Callable[[int], None] = lambda mission: None
        self._jobs: Dict[int, QueuedJob] = {}
        self._open: Dict[int, str] = {}     # the id of each open job in lower case, by its mission
        self._ids: Set[str] = set()         # the ids in _open
        self._ended: Dict[int, int] = {}    # when each ended job ended, the oldest first
        for job in sorted(jobs, key=lambda job: job.segments[0].number):
            self.put(job)
        self._ended = dict(sorted(self._ended.items(), key=lambda one: one[1]))

    def __contains__(self, mission: int) -> bool:
        """Whether there is a job with this mission."""
        return mission in self._jobs

    def __getitem__(self, mission: int) -> QueuedJob:
        """Returns the job with a mission. Raises KeyError."""
        return self._jobs[mission]

    def get(self, mission: int) -> Optional[QueuedJob]:
        """Returns the job with a mission; None: there is none."""
        return self._jobs.get(mission)

    @property
    def all(self) -> Sequence[QueuedJob]:
        """All jobs, the oldest first."""
        return tuple(self._jobs.values())

    @property
    def open(self) -> Sequence[QueuedJob]:
        """The jobs that have not ended, the oldest first."""
        return [self._jobs[mission] for mission in self._open]

    @property
    def open_ids(self) -> Set[str]:
        """The ids of the jobs that have not ended, in lower case."""
        return self._ids

    def put(self, job: QueuedJob) -> None:
        """Adds a job, or replaces the job with the same mission."""
        mission = job.mission
        self._jobs[mission] = job
        if job.is_open:
            if mission not in self._open:
                self._open[mission] = job.id.lower()
                self._ids.add(job.id.lower())
        else:
            id = self._open.pop(mission, None)
            if id is not None:
                self._ids.discard(id)
            self._ended.setdefault(mission, job.segments[-1].ended)
        self.on_change(mission)

    def too_old(self, since: int, most: int) -> List[int]:
        """Returns the missions of the ended jobs to forget, so that at most `most` are left.

        since -- ms since 1970; a job that ended before this moment is forgotten in any case
        """
        left = len(self._ended) - most
        found: List[int] = []
        for mission, end in self._ended.items():
            if len(found) >= left and end >= since:
                break
            found.append(mission)
        return found

    def forget(self, mission: int) -> None:
        """Removes a job that has ended."""
        del self._jobs[mission], self._ended[mission]
        self.on_change(mission)
