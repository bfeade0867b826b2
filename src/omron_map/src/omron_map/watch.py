"""Detects changes of a map file, and waits for a map file that another program creates.

    watcher = MapWatcher(path)          # before the first load, so that no change is missed
    if not watcher.unfinished:
        document = MapDocument.load(path)
    ...
    if watcher.changed():               # from a timer, about twice a second
        document = MapDocument.load(path)
"""
from __future__ import annotations

import time
from typing import Callable, Iterable, Optional, Tuple

from omron_map.errors import MapError
from omron_map.regular_file import status_of, status_or_error
from omron_map.text import printable_path

POLL_PERIOD = 0.1  # s
SETTLED = 2.0  # s; a file that has not changed for this time counts as complete
_Signature = Tuple[int, int, int]


class MapWatcher:
    """Detects that a file was replaced or rewritten, after the file has settled.

    A program that writes a map in place may pause during writing. The incomplete file can then be a
    valid map with fewer points. So a change is reported only when the file has stayed the same for
    `settled` seconds of `clock`. The absence of the file does not count as a change.
    """

    def __init__(self, path: str, settled: float = SETTLED,
                 clock: Callable[[], float] = time.monotonic) -> None:
        self.path = path
        self._settled = settled
        self._clock = clock
        status = status_of(path)
        self._seen = _signature(path)
        self._since = clock()
        fresh = status is not None and abs(time.time() - status.st_mtime) < settled
        self._told = None if fresh else self._seen

    @property
    def unfinished(self) -> bool:
        """Whether the file is so new that `changed` will report it when it has settled."""
        return self._told is None and self._seen is not None

    def changed(self) -> bool:
        """Returns True once for each change, when the file differs from the last reported state."""
        now, signature = self._clock(), _signature(self.path)
        if signature != self._seen:
            self._seen, self._since = signature, now
        if signature in (None, self._told) or now - self._since < self._settled:
            return False
        self._told = signature
        return True


def _signature(path: str) -> Optional[_Signature]:
    status = status_of(path)
    return (status.st_mtime_ns, status.st_size, status.st_ino) if status else None


def wait_for_map(path: str, made_from: Iterable[str] = (), timeout: float = 30.0,
                 say: Callable[[str], object] = print,
                 given_up: Callable[[], bool] = lambda: False) -> None:
    """Waits until `path` exists and is at least as new as every file in `made_from`.

    Nodes and simulator wait in this way for the converter that creates their map.
    say      -- called once with a text, if the function has to wait
    given_up -- returns whether to end the wait early
    Raises MapError after `timeout` seconds or if `given_up` returns True, and at once if a file in
    `made_from` is missing.
    """
    deadline = time.monotonic() + timeout
    sources = [source for source in made_from if source]
    said = False
    while True:
        newest = max((_modified(source) for source in sources), default=0)
        try:
            if status_or_error(path).st_mtime_ns >= newest:
                return
            problem = 'it is older than its source files: ' + ', '.join(sources)
        except MapError as error:
            problem = error.problem
        if time.monotonic() >= deadline or given_up():
            raise MapError(path, f'{problem}; waited {timeout:.0f} s for its creation',
                           expected='a file from the map converter')
        if not said:
            say(f'Waiting up to {timeout:.0f} s for the creation of {printable_path(path)}: '
                f'{problem}.')
            said = True
        time.sleep(POLL_PERIOD)


def _modified(path: str) -> int:
    try:
        return status_or_error(path).st_mtime_ns
    except MapError as error:
        raise MapError(path, 'the map is created from this file, but '
                       f'{error.problem}') from None
