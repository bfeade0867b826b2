"""Noticing that a map file has changed, and waiting for one that is being made.

Every program that shows or uses the displayed map follows its file in the same way:

    watcher = MapWatcher(path)          # before the first load, so that no change is missed
    document = MapDocument.load(path)
    ...
    if watcher.changed():               # from a timer, about twice a second
        document = MapDocument.load(path)
"""
from __future__ import annotations

import os
import time
from typing import Callable, Iterable, Optional, Tuple

from omron_map.errors import MapError

POLL_PERIOD = 0.1  # s


class MapWatcher:
    """Notices when a file was replaced or rewritten and has settled since.

    A file that is being written in place changes from one poll to the next, so a change is told
    only when two polls in a row have seen the same file. A file that is absent is no change.
    """

    def __init__(self, path: str) -> None:
        self.path = path
        self._known = self._polled = _signature(path)

    def changed(self) -> bool:
        """True once for every change: the file now differs from the last one told of."""
        before, self._polled = self._polled, _signature(self.path)
        if self._polled is None or self._polled != before or self._polled == self._known:
            return False
        self._known = self._polled
        return True


def _signature(path: str) -> Optional[Tuple[int, int, int]]:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino


def wait_for_map(path: str, made_from: Iterable[str] = (), timeout: float = 30.0,
                 say: Callable[[str], object] = print,
                 given_up: Callable[[], bool] = lambda: False) -> None:
    """Wait until `path` exists and is at least as new as every file in `made_from`.

    So nodes and simulator wait for the converter that makes their map. `say` is told once that
    there is something to wait for; `given_up` ends the wait early. Raises MapError after `timeout`
    seconds, when given up, and at once when a file in `made_from` is missing.
    """
    deadline = time.monotonic() + timeout
    sources = [source for source in made_from if source]
    said = False
    while True:
        newest = max((_modified(source) for source in sources), default=0)
        try:
            if os.stat(path).st_mtime_ns >= newest:
                return
            problem = 'it is older than what it is made from: ' + ', '.join(sources)
        except OSError as error:
            problem = f'it cannot be read ({error.strerror})'
        if time.monotonic() >= deadline or given_up():
            raise MapError(path, f'{problem}; waited {timeout:.0f} s for it to be made',
                           expected='the map converter to have written it')
        if not said:
            say(f'Waiting up to {timeout:.0f} s for {path} to be made: {problem}.')
            said = True
        time.sleep(POLL_PERIOD)


def _modified(path: str) -> int:
    try:
        return os.stat(path).st_mtime_ns
    except OSError as error:
        raise MapError(path, f'the map is made from this file, which cannot be read '
                             f'({error.strerror})') from error
