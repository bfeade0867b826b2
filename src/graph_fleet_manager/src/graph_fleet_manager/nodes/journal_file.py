"""The journal that ~journal names, as soon as it can be opened; it keeps ~keep_days of history."""
from __future__ import annotations

import os
from contextlib import suppress
from typing import Optional

import rospkg
import rospy

from graph_fleet_manager.supervision.journal import Journal
from graph_fleet_manager.supervision.journal_database import JournalError, JournalUnavailable
from graph_fleet_manager.supervision.outbox import AGAIN
from node_lifecycle import ConfigurationError, number, parameter

DAY = 86400.0          # s
FORGET_PERIOD = 10.0   # s between two looks for missions that ended long ago


class JournalFile:
    """The journal; raises ConfigurationError where its file can never be one.

    trouble -- why it cannot be used, a clause; empty: it can, as far as is known
    """

    def __init__(self) -> None:
        self.journal: Optional[Journal] = None
        self.trouble = ''
        self._path = _path()
        self._keep = DAY * number('~keep_days', 90.0, 1.0, 36500.0)
        self._try_at = self._forget_at = 0.0
        self.open(0.0)

    def open(self, now: float) -> None:
        """Opens it if it is not open, and the last try did not just fail."""
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
        """Deletes what ended long ago, a little at a time; a disk that is full does not matter."""
        if self.journal is None or now < self._forget_at:
            return
        self._forget_at = now + FORGET_PERIOD
        with suppress(JournalUnavailable):  # the next thing to be stored tells of it
            self.journal.forget(self._keep)

    def fail(self, unavailable: JournalUnavailable) -> None:
        """It turned out that it cannot be used now."""
        if not self.trouble:
            rospy.logerr('%s Until then no mission is accepted and no robot gets anything to '
                         'drive; stops are sent.', unavailable)
        self.trouble = unavailable.reason

    def mended(self) -> None:
        """It turned out that it can be used."""
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
