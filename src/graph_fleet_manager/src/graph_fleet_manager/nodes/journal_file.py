"""The journal in the file of ~journal. It keeps a mission for ~keep_days after its end."""
from __future__ import annotations

import os
from contextlib import suppress
from typing import Optional

import rospkg
import rospy

from fleet_core.supervision.journal import Journal
from fleet_core.supervision.journal_database import JournalError, JournalUnavailable
from fleet_core.supervision.outbox import AGAIN
from node_lifecycle import ConfigurationError, number, parameter

DAY = 86400.0          # s
FORGET_PERIOD = 10.0   # s between two deletions of missions that ended long ago


class JournalFile:
    """The journal and its state. Raises ConfigurationError if the file can never hold a journal.

    journal -- None until the file has been opened
    trouble -- a clause that says why the journal cannot be used; empty if no reason is known
    """

    def __init__(self) -> None:
        self.journal: Optional[Journal] = None
        self.trouble = ''
        self._path = _path()
        self._keep = DAY * number('~keep_days', 90.0, 1.0, 36500.0)
        self._try_at = self._forget_at = 0.0
        self.open(0.0)

    def open(self, now: float) -> None:
        """Opens the journal if it is closed and the last failed attempt is long enough ago."""
        if self.journal is not None or now < self._try_at:
            return
        self._try_at = now + AGAIN
        try:
            self.journal = Journal(self._path)
        except JournalUnavailable as unavailable:
            self.fail(unavailable)
        except JournalError as error:
            raise ConfigurationError(str(error)) from None
        else:
            self.trouble = ''

    def forget(self, now: float) -> None:
        """Deletes some missions that ended long ago. Ignores a full disk."""
        if self.journal is None or now < self._forget_at:
            return
        self._forget_at = now + FORGET_PERIOD
        with suppress(JournalUnavailable):  # the next attempt to store something reports it
            self.journal.forget(self._keep)

    def fail(self, unavailable: JournalUnavailable) -> None:
        """Notes that the journal cannot be used now. Logs only the first of such failures."""
        if not self.trouble:
            rospy.logerr('%s Until then no mission is accepted and no robot gets anything to '
                         'drive; stops are sent.', unavailable)
        self.trouble = unavailable.reason

    def mended(self) -> None:
        """Notes that the journal can be used again."""
        self.trouble = ''


def _path() -> str:
    path: str = parameter('~journal', '')
    path = path or os.path.join(rospkg.get_ros_home(), 'graph_fleet_manager', 'fleet.sqlite')
    try:
        os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
    except OSError as error:
        raise ConfigurationError(f'The folder of the journal {path} cannot be made '
                                 f'({error.strerror}); choose another with ~journal.') from None
    return path
