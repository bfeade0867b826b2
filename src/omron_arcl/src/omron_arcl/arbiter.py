"""Commands of several givers for one robot, in the order in which they were given."""
from __future__ import annotations

import threading
import time
from typing import Any, Callable, Optional
from weakref import WeakKeyDictionary

from omron_arcl.commands import Command
from omron_arcl.errors import ArclError
from omron_arcl.execution import Execution, Outcome, Result
from omron_arcl.guard import Guard
from omron_arcl.overruling import Motion, Overruling
from omron_arcl.replies import Motors, Stopping
from omron_arcl.replies.reply import Reply


class Arbiter:
    """Gives a client what is allowed and passes nobody's word (see `overruling`).

    execute, cancel -- those of an `omron_arcl.Client`
    Any thread may call.
    """

    def __init__(self, execute: Callable[..., Execution], cancel: Callable[[Execution], None],
                 guard: Guard, clock: Callable[[], float] = time.monotonic) -> None:
        self._execute = execute
        self._cancel = cancel
        self._guard = guard
        self._overruling = Overruling(clock)
        self._motions: WeakKeyDictionary[Execution, Motion] = WeakKeyDictionary()
        self._giving = threading.Lock()  # commands are given one at a time

    def execute(self, text: str, giver: str, *, on_end: Optional[Callable[[Result], None]] = None,
                **options: Any) -> Execution:
        """Gives a command of `giver`, any name; `options` as the client's. Raises ArclError."""
        motion: Optional[Motion] = None

        def check(command: Command) -> None:
            nonlocal motion
            self._guard.check(command)
            motion = self._overruling.take(giver, command)

        def end(result: Result) -> None:
            if motion:
                self._overruling.ended(motion, result.outcome)
            if on_end:
                on_end(result)

        with self._giving:
            try:
                execution = self._execute(text, check=check, on_end=end, **options)
            except ArclError:
                if motion:
                    self._overruling.ended(motion, Outcome.LOST)
                raise
            if motion:
                self._motions[execution] = motion
        return execution

    def cancel(self, execution: Execution, canceller: str) -> None:
        """Cancels a command for `canceller`, so that no drive follows that was given before."""
        with self._giving:
            if execution in self._motions:
                self._overruling.cancelled(self._motions[execution], canceller)
            self._cancel(execution)

    def on_reply(self, reply: Reply) -> None:
        """The robot said a line, be it about a command of ours or not."""
        if isinstance(reply, Stopping):
            self._overruling.stopping()
        elif isinstance(reply, Motors) and reply.enabled:
            self._overruling.powered()
