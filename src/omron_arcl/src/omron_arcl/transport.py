"""The thread that serves connections and reports their state; base of `ArclLink` and `Listener`."""
from __future__ import annotations

import contextlib
import logging
import selectors
import socket
import threading
import time
from typing import Any, Callable, Optional, Set, TypeVar

from omron_arcl.connection import reason_of
from omron_arcl.errors import ConnectionLost, LinkError
from omron_arcl.link import Link, LinkPhase

TICK = 0.2  # s, longest wait for an event
_log = logging.getLogger(__name__)
_Own = TypeVar('_Own', bound='Transport')


class Waker:
    """Ends the wait of a thread in a selector; another thread calls `wake`."""

    def __init__(self) -> None:
        self.reader, self._writer = socket.socketpair()
        self.reader.setblocking(False)
        self._writer.setblocking(False)

    def wake(self) -> None:
        """Ends the wait; harmless after `close`."""
        with contextlib.suppress(OSError):
            self._writer.send(b'\0')

    def drain(self) -> None:
        """Clears all requests that `wake` has made so far."""
        with contextlib.suppress(OSError):
            self.reader.recv(1024)

    def close(self) -> None:
        """Frees the descriptors."""
        self.reader.close()
        self._writer.close()


class Transport:
    """A thread that serves connections from `start` until `close`; also a context manager.

    `link` is the state of the connection; `on_link` is called when it changes. A subclass defines
    `_run` and extends `_free`. `_run` must end soon after `_closing` is set; `_waker` wakes it.
    """

    def __init__(self, name: str, link: Link, on_link: Optional[Callable[[Link], None]]) -> None:
        self.link = link
        self._on_link = on_link
        self._name = name
        self._closing = threading.Event()
        self._waker = Waker()
        self._thread = threading.Thread(target=self._run_and_free, name=name, daemon=True)
        self._starting = threading.Lock()
        self._started = False
        self._ready: Set[object] = set()

    def start(self: _Own) -> _Own:
        """Begins to connect or to listen. Does nothing at a second call, or after `close`."""
        with self._starting:
            if not (self._started or self._closing.is_set()):
                self._started = True
                self._thread.start()
        return self

    def __enter__(self: _Own) -> _Own:
        return self.start()

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection; commands under way end as lost. Takes well under a second."""
        with self._starting:
            first = not self._closing.is_set()
            self._closing.set()
        if not self._started:
            if first:
                self._free()
        else:
            self._waker.wake()
            if threading.current_thread() is not self._thread:
                self._thread.join(1.0)

    def _run_and_free(self) -> None:
        try:
            self._run()
        finally:
            self._free()

    def _run(self) -> None:
        raise NotImplementedError

    def _free(self) -> None:
        """Releases the resources that were taken at construction."""
        self._waker.close()

    def _wait(self, selector: selectors.BaseSelector) -> float:
        """Waits for an event; returns the waiting time in s. The ready sockets are in `_ready`."""
        begun = time.monotonic()
        self._ready = {key.fileobj for key, _ in selector.select(TICK)}
        if self._waker.reader in self._ready:
            self._waker.drain()
        return time.monotonic() - begun

    def _set_link(self, phase: LinkPhase, peer: str, reason: str = '') -> None:
        self.link = Link(phase, peer, reason)
        self._call(self._on_link, self.link)

    def _cause(self, error: Exception) -> LinkError:
        """Returns the cause to report for a connection that ended because of `error`.

        An internal error is also logged.
        """
        if isinstance(error, LinkError):
            return error
        if isinstance(error, OSError):
            return ConnectionLost(f'the connection broke: {reason_of(error)}')
        _log.error('The %s failed.', self._name, exc_info=error)
        return ConnectionLost(f'an internal error: {error!r}')

    def _call(self, callback: Optional[Callable[..., None]], *arguments: Any) -> None:
        """Calls a callback; an error in it is logged and does not end the connection."""
        if callback:
            try:
                callback(*arguments)
            except Exception:
                _log.exception('A callback of the %s failed.', self._name)
