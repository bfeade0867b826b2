"""All jobs that are handed to one Fleet Manager, across lost links and restarts of both sides.

Only one command or query at a time waits for its answer, because answers have no number.

    event         what follows
    request       the job is stored, then it is sent as soon as there is a link
    login         each job that the Fleet Manager may have is queried, before other lines are sent
    answer ends   the job is changed according to the answer; the next command is due
    error         the job is queried: it was refused only if the Fleet Manager does not know it
    modification  it is stored; then each value that the Fleet Manager does not show is sent, once
                  per link, and the job is queried: the answer shows whether the value was changed
    loss          the command without an answer is dropped: its job is queried after a login
    restart       as after a loss, with the jobs that are on the disk

Invariants: a job is on the disk as SENT before its command is sent. A job is sent again only if the
Fleet Manager says within RESENT_WITHIN after the sending that it does not know the job. A later
"not known" is no proof, because a Fleet Manager forgets jobs that have ended (by default after 60
minutes, or 100 later jobs): such a job ends as UNKNOWN, and a person decides. A modified value is
sent only if the Fleet Manager showed another value over this link, because each such command
interrupts the drive.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Dict, Iterable, List, Optional, Sequence, Set, Tuple

from omron_jobs.client.fleet_manager_lines import (
    MODIFY,
    QUERY,
    AnswerEnd,
    ErrorBegin,
    ErrorText,
    SegmentLine,
    WrongJob,
    cancellation_of,
    check,
    command_of,
    modification_of,
    query_of,
    read_line,
)
from omron_jobs.client.handed_jobs import (
    FINAL_STATUSES,
    MODIFYING_STATUSES,
    HandedEvent,
    HandedJob,
    HandedState,
    HandedStop,
)

RESENT_WITHIN = 300.0   # s after sending, within which an unknown job is sent again
ANSWERED_WITHIN = 10.0  # s to wait for an answer before the link is ended
ASKED_EVERY = 10.0      # s without news of an open job, after which it is queried
MOST_OPEN = 1000
MOST_ENDED = 1000       # largest number of ended jobs that are kept for their callers

Store = Callable[[Sequence[HandedJob]], None]
"""Stores all jobs, forced to the disk. Raises OSError."""


class TooManyJobs(Exception):
    """So many jobs are open that no further job is accepted."""


@dataclass(frozen=True)
class _Question:
    """The command without an answer yet: its name in lower case, its job, and when it was sent."""

    command: str
    job: str
    since: float
    listed: Tuple[str, ...] = ()    # ids of segments in the answer so far
    is_error: bool = False      # the first line of an error came


class JobClient:
    """The state machine of this module. `clock`: wall clock in ms. `new_id`: draws a job's id.

    It has many attributes because it has the jobs, their file, and the state of one link.
    """

    def __init__(self, jobs: Iterable[HandedJob], store: Store, clock: Callable[[], int],
                 new_id: Callable[[], str]) -> None:
        self._jobs: Dict[str, HandedJob] = {job.id: job for job in jobs}
        self._store, self._clock, self._new_id = store, clock, new_id
        self._is_linked = False
        self._question: Optional[_Question] = None
        self._heard: Dict[str, float] = {}      # when the last news of each job came on this link
        self._asked: Dict[str, float] = {}      # when each job was queried on this link
        self._errors: Dict[str, str] = {}       # why a job was refused, until it is queried
        self._unsure: Set[str] = set()          # jobs to query after the answer to a modification
        self._tried: Set[str] = set()           # modifications that were sent on this link
        self._changed: Dict[str, HandedJob] = {}
        self._is_stored = True
        self.problem = ''                       # why the Fleet Manager answers no query

    @property
    def jobs(self) -> List[HandedJob]:
        """All jobs, the oldest first."""
        return list(self._jobs.values())

    def request(self, stops: Tuple[HandedStop, ...], request: str = '') -> HandedJob:
        """Stores a job and returns it. A job that was requested before is returned unchanged.

        Raises WrongJob, TooManyJobs or OSError; then no job was stored.
        """
        known = next((job for job in self._jobs.values() if request and job.request == request),
                     None)
        if known is not None:
            return known
        id = self._new_id()
        while id in self._jobs:
            id = self._new_id()
        job = HandedJob(id, stops, request)
        check(job)
        if sum(one.is_open for one in self._jobs.values()) >= MOST_OPEN:
            raise TooManyJobs(f'{MOST_OPEN} jobs are open')
        self._keep(job)
        return job

    def modify(self, request: str, stops: Tuple[HandedStop, ...]) -> HandedJob:
        """Gives the job of a request other goals or priorities, and returns it.

        Raises WrongJob or OSError; then nothing has changed.
        """
        job = next((job for job in self._jobs.values() if request and job.request == request),
                   None)
        if job is None:
            raise WrongJob(f'there is no job {request!r}')
        if stops == (job.wanted or job.stops):
            return job
        if [stop.kind for stop in stops] != [stop.kind for stop in job.stops]:
            raise WrongJob('it has other pickups and drop-offs than its job')
        check(replace(job, stops=stops))
        if not job.is_open or job.is_unwanted:
            raise WrongJob('its job has ended, or is cancelled')
        if job.wanted:
            raise WrongJob('another modification of its job is under way')
        job = job.modified(stops)
        self._keep(job.settled())
        self._tried -= {modification_of(change) for change in job.changes}
        return self._jobs[job.id]

    def cancel(self, id: str) -> None:
        """Cancels a job. A job that was not sent ends at once. Any other job ends when the Fleet
        Manager reports its end.

        Raises OSError; then the job is not cancelled.
        """
        job = self._jobs.get(id)
        if job is not None and job.is_open and not job.is_unwanted:
            self._keep(replace(job, is_unwanted=True).after(HandedEvent.WITHDRAWN))
            self._asked.pop(id, None)

    def hear_login(self) -> None:
        """Begins a link."""
        self.hear_loss()
        self._is_linked, self.problem = True, ''

    def hear_loss(self) -> None:
        """Ends the link; the command without an answer is in doubt."""
        self._is_linked, self._question = False, None
        self._heard.clear()
        self._asked.clear()
        self._unsure.clear()
        self._tried.clear()

    def hear_line(self, text: str, now: float) -> None:
        """Reads a line of the Fleet Manager."""
        line, question = read_line(text), self._question
        if isinstance(line, SegmentLine):
            self._hear_segment(line, now)
        elif question is None:
            return
        elif isinstance(line, AnswerEnd) and line.command == question.command:
            self._end_question(question, line.linked, now)
        elif isinstance(line, ErrorBegin) and line.command == question.command:
            self._question = replace(question, is_error=True)
        elif isinstance(line, ErrorText) and (line.is_whole or question.is_error):
            self._question = None
            if question.command == QUERY:
                self.problem = f'the Fleet Manager answers no queueQuery: {line.text}'
            elif question.command == MODIFY:
                self._end_modification(question.job, line.text)
            else:
                self._errors[question.job] = line.text

    def due(self, now: float) -> List[str]:
        """Returns the lines to send now. A job is stored as SENT before its command is returned.

        Raises OSError; then nothing is to be sent.
        """
        if not self._is_linked or self._question is not None or self.problem:
            return []
        asked = self._next_to_ask(now)
        if asked is not None:
            self._question = _Question(QUERY, asked.id, now)
            self._asked[asked.id] = now
            self._unsure.discard(asked.id)
            return [*([cancellation_of(asked)] if asked.is_unwanted else []), query_of(asked)]
        modification = self._next_modification()
        if modification is not None:
            id, line = modification
            self._question = _Question(MODIFY, id, now)
            self._tried.add(line)
            return [line]
        job = next((job for job in self._jobs.values() if job.state is HandedState.STORED), None)
        if job is None:
            return []
        line = command_of(job)
        self._keep(replace(job, sent=self._clock()).after(HandedEvent.SENDING))
        self._question = _Question(line.partition(' ')[0].lower(), job.id, now)
        return [line]

    def is_stuck(self, now: float) -> bool:
        """Returns whether an answer is so late that the link is to be given up."""
        return self._question is not None and now - self._question.since > ANSWERED_WITHIN

    def store_news(self) -> None:
        """Stores the changes that came with lines. Raises OSError; the next call tries again."""
        if not self._is_stored:
            self._store(self.jobs)
            self._is_stored = True

    def pop_changes(self) -> List[HandedJob]:
        """Returns the jobs that have changed since the last call, each as it is now."""
        changed, self._changed = list(self._changed.values()), {}
        return changed

    # -- lines of the Fleet Manager ----------------------------------------------------------------

    def _hear_segment(self, line: SegmentLine, now: float) -> None:
        job = self._jobs.get(line.job)
        if job is None:
            return
        self._heard[job.id] = now
        question = self._question
        if line.is_listed and question is not None and question.job == job.id:
            self._question = replace(question, listed=(*question.listed, line.segment.id))
        self._errors.pop(job.id, None)
        self._put(job.with_segment(line.segment, line.robot))

    def _end_question(self, question: _Question, linked: str, now: float) -> None:
        self._question = None
        job = self._jobs.get(question.job)
        self._heard[question.job] = now
        if job is None:
            return
        if question.command == MODIFY:
            self._unsure.add(job.id)
        elif question.command != QUERY:
            job = replace(job, linked=linked or job.linked)
            self._put(job.after(HandedEvent.ACCEPTED) if job.state is HandedState.SENT else job)
        elif question.listed:
            self._put(job.after_listing(question.listed))
            self._judge_modification(self._jobs[job.id])
        else:
            self._hear_not_known(job)

    def _hear_not_known(self, job: HandedJob) -> None:
        error = self._errors.pop(job.id, None)
        age = (self._clock() - job.sent) / 1000.0
        if error is not None:
            self._put(replace(job, reason=error).after(HandedEvent.REFUSED))
        elif not 0.0 <= age <= RESENT_WITHIN:
            self._put(job.after(HandedEvent.FORGOTTEN))
        else:
            job = job.after(HandedEvent.NOT_KNOWN)
            self._put(job.after(HandedEvent.WITHDRAWN) if job.is_unwanted else job)

    def _judge_modification(self, job: HandedJob) -> None:
        """Ends a modification that was not done, according to the newest listing of the job."""
        for change in job.changes:
            if change.segment.status in FINAL_STATUSES:
                self._end_modification(job.id, f'{change.segment.id} has ended')
                return
            if change.segment.status not in MODIFYING_STATUSES \
                    and modification_of(change) in self._tried:
                self._end_modification(job.id, f'{change.segment.id} keeps its {change.field}')
                return

    def _end_modification(self, id: str, reason: str) -> None:
        job = self._jobs.get(id)
        if job is not None and job.wanted:
            self._put(job.refused(reason))

    def _next_modification(self) -> Optional[Tuple[str, str]]:
        """Returns the job and the command of a modification that is due."""
        for job in self._jobs.values():
            for change in job.changes if job.is_in_hand and not job.is_unwanted else ():
                line = modification_of(change)
                if line not in self._tried \
                        and change.segment.status not in (*FINAL_STATUSES, *MODIFYING_STATUSES):
                    return job.id, line
        return None

    def _next_to_ask(self, now: float) -> Optional[HandedJob]:
        return next((job for job in self._jobs.values()
                     if job.is_in_hand and self._is_to_be_asked(job, now)), None)

    def _is_to_be_asked(self, job: HandedJob, now: float) -> bool:
        """Returns whether to query a job: there was an error, a modification, or no recent news.

        A job to be cancelled is queried, and its cancellation repeated, until it has ended.
        """
        times = self._asked if job.is_unwanted else self._heard
        return (job.id in self._errors or job.id in self._unsure or job.id not in times
                or now - times[job.id] >= ASKED_EVERY)

    # -- the disk ----------------------------------------------------------------------------------

    def _keep(self, job: HandedJob) -> None:
        """Stores a job on the disk, then changes or adds it in memory."""
        jobs = {**self._jobs, job.id: job}
        ended = [one.id for one in jobs.values() if not one.is_open]
        for id in ended[:max(0, len(ended) - MOST_ENDED)]:
            del jobs[id]
        self._store(list(jobs.values()))
        self._jobs, self._is_stored = jobs, True
        self._changed[job.id] = job

    def _put(self, job: HandedJob) -> None:
        """Adopts a change of a job that the Fleet Manager has reported.

        The change is stored later: if it is lost, the Fleet Manager can be queried again.
        """
        job = job.settled()
        if job != self._jobs[job.id]:
            self._jobs[job.id] = self._changed[job.id] = job
            self._is_stored = False
