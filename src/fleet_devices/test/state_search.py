"""The search through all states of a small world, for both state machines of fleet_devices."""
from __future__ import annotations

from collections import deque
from typing import Callable, Deque, Dict, Iterable, List, Optional, Tuple, TypeVar

State = TypeVar('State')


class Broken(AssertionError):
    """An invariant does not hold. The arguments: its name, the path to the state, and why."""


def visited(first: State, key: Callable[[State], object],
            events: Callable[[State], Iterable[Tuple[str, Callable[[State], State]]]],
            check: Callable[[State], None]) -> int:
    """Visits every state. Returns the number of states; raises Broken with the path to the state.

    key    -- returns a value that is equal for equal states
    events -- returns the events that can happen in a state, with names; an event may raise Broken
    check  -- raises Broken for a state that is wrong
    """
    seen: Dict[object, Tuple[Optional[object], str]] = {key(first): (None, 'start')}
    waiting: Deque[Tuple[object, State]] = deque([(key(first), first)])
    while waiting:
        here, state = waiting.popleft()
        name = ''
        try:
            check(state)
            for name, event in events(state):
                after = event(state)
                there = key(after)
                if there not in seen:
                    seen[there] = here, name
                    waiting.append((there, after))
        except Broken as broken:
            way: List[str] = [name]
            at: Optional[object] = here
            while at is not None:
                at, event_name = seen[at]
                way.append(event_name)
            raise Broken(broken.args[0], ' -> '.join(reversed(way)), *broken.args[1:]) from None
    return len(seen)
