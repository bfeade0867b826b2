"""Looks up the addresses of a host in a separate thread, because a name server may be slow."""
from __future__ import annotations

import ipaddress
import logging
import threading
import time
from typing import Callable, FrozenSet, Optional

from omron_arcl.connection import reason_of, resolve

AGAIN = 5.0  # s until the next look-up after a failure
_log = logging.getLogger(__name__)


class HostAddresses:
    """The addresses of `host`, from `start` until `close`.

    The addresses are looked up at the start, after every failure, and when `belongs` needs a newer
    answer. While the name server does not answer, the last known addresses stay valid. `on_answer`
    runs after each look-up, in the look-up thread. If `host` is an address, nothing is looked up.
    """

    def __init__(self, host: str, on_answer: Callable[[], None]) -> None:
        self._host = host
        self._on_answer = on_answer
        self._known: FrozenSet[str] = frozenset()
        self._answered = -1.0  # when the last finished look-up began
        self._is_asked = True
        self._is_closed = False
        self._change = threading.Condition()
        self._thread: Optional[threading.Thread] = None
        if _is_address(host):
            self._known = frozenset(entry[4][0] for entry in resolve(host))
        else:
            self._thread = threading.Thread(target=self._run, name='host addresses', daemon=True)

    def start(self) -> None:
        """Starts the first look-up."""
        if self._thread:
            self._thread.start()

    def close(self) -> None:
        """Ends the thread. A thread that waits for a name server ends after the answer."""
        with self._change:
            self._is_closed = True
            self._change.notify()

    def belongs(self, address: str, since: float) -> Optional[bool]:
        """Returns whether `address` is an address of the host.

        None: no look-up that began after `since` (s, monotonic) has ended yet. `on_answer` is
        called when one ends.
        """
        with self._change:
            if self._thread is None or self._answered >= since:
                return address in self._known
            self._is_asked = True
            self._change.notify()
            return True if address in self._known else None

    def _run(self) -> None:
        timeout: Optional[float] = None
        while True:
            with self._change:
                self._change.wait_for(lambda: self._is_asked or self._is_closed, timeout)
                if self._is_closed:
                    return
                self._is_asked = False
            timeout = None if self._resolve() else AGAIN
            self._on_answer()

    def _resolve(self) -> bool:
        begun = time.monotonic()
        try:
            found = frozenset(str(entry[4][0]) for entry in resolve(self._host))
        except OSError as error:
            _log.warning('The robot "%s" has no address: %s.', self._host, reason_of(error))
            found = None
        with self._change:
            self._answered = begun
            self._known = self._known if found is None else found
        return found is not None


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
