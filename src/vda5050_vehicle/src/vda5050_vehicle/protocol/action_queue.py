"""Actions from their reception to their end: what waits, what may start, what holds the vehicle.

Actions are triggered in the order in which their nodes and edges are reached; figure 17 of the
standard says which of them may run beside each other, and which need the vehicle to stand.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from typing import Dict, Iterable, List, Optional, Sequence, Tuple

from vda5050_vehicle.protocol.values import Action, ActionState, ActionStatus

MAX_ENDED_INSTANT_ACTIONS = 100  # told: until the next order, in 3.0 until they are cleared


class Scope(Enum):
    """Where an action came from."""

    INSTANT = 'INSTANT'
    NODE = 'NODE'
    EDGE = 'EDGE'


@dataclass(frozen=True)
class Entry:
    """An action and how far it is.

    sequence_id -- of its node or edge; -1 for an instant action
    triggered   -- its node was passed, its edge entered; or it came to be done at once
    """

    action: Action
    scope: Scope
    sequence_id: int = -1
    status: ActionStatus = ActionStatus.WAITING
    triggered: bool = False
    result: Optional[str] = None

    @property
    def is_active(self) -> bool:
        """Whether it was started and has not ended; INITIALIZING it is to be tried again."""
        return self.status in (ActionStatus.RUNNING, ActionStatus.PAUSED, ActionStatus.RETRIABLE)

    @property
    def belongs_to_order(self) -> bool:
        """Whether it came with an order."""
        return self.scope is not Scope.INSTANT

    @property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand for it, once it is triggered and until it has ended."""
        return self.action.blocking_type.forbids_driving and not self.status.has_ended


class ActionQueue:
    """All actions that the state tells of."""

    def __init__(self, entries: Iterable[Entry] = (), triggered: Iterable[str] = ()) -> None:
        """`triggered` are the ids of those triggered, in order."""
        self._entries: Dict[str, Entry] = {entry.action.action_id: entry for entry in entries}
        self._triggered: List[str] = list(triggered)

    def __contains__(self, action_id: str) -> bool:
        return action_id in self._entries

    def __getitem__(self, action_id: str) -> Entry:
        return self._entries[action_id]

    @property
    def entries(self) -> Tuple[Entry, ...]:
        """As they came."""
        return tuple(self._entries.values())

    @property
    def triggered(self) -> Tuple[str, ...]:
        """Ids of those triggered and not ended, in the order in which they are to run."""
        return tuple(self._triggered)

    @property
    def states(self) -> Tuple[ActionState, ...]:
        """What the master is told."""
        return tuple(
            ActionState(entry.action.action_id, entry.action.action_type, entry.status,
                        entry.action.description, entry.result,
                        not entry.belongs_to_order) for entry in self.entries)

    # --- coming and going -------------------------------------------------------------------------

    def add(self, actions: Iterable[Action], scope: Scope, sequence_id: int = -1) -> None:
        """Actions that came."""
        for action in actions:
            self._entries[action.action_id] = Entry(action, scope, sequence_id)
        for action_id in self._ended_instant_actions[:-MAX_ENDED_INSTANT_ACTIONS]:
            del self._entries[action_id]

    @property
    def _ended_instant_actions(self) -> List[str]:
        return [entry.action.action_id for entry in self.entries
                if not entry.belongs_to_order and entry.status.has_ended]

    @property
    def is_full(self) -> bool:
        """Whether the oldest of the instant actions that have ended is forgotten next."""
        return len(self._ended_instant_actions) >= MAX_ENDED_INSTANT_ACTIONS

    def begin_order(self, keep_instant: bool = False) -> None:
        """Forgets the order before, and instant actions that have ended unless they are kept."""
        self._keep(entry for entry in self.entries if not entry.belongs_to_order
                   and (keep_instant or not entry.status.has_ended))

    def clear_instant_actions(self) -> None:
        """Forgets instant actions that have ended."""
        ended = set(self._ended_instant_actions)
        self._keep(entry for entry in self.entries if entry.action.action_id not in ended)

    def drop(self, sequence_ids: Iterable[int]) -> None:
        """Forgets the actions of a horizon that is replaced."""
        gone = set(sequence_ids)
        self._keep(entry for entry in self.entries if entry.sequence_id not in gone)

    def _keep(self, entries: Iterable[Entry]) -> None:
        self._entries = {entry.action.action_id: entry for entry in entries}
        self._triggered = [action_id for action_id in self._triggered if action_id in self]

    def trigger_element(self, sequence_id: int) -> None:
        """The node was passed, or the edge entered."""
        for entry in self.of(sequence_id):
            if not entry.triggered and not entry.status.has_ended:
                self.trigger(entry.action.action_id)

    def trigger(self, action_id: str) -> None:
        """It is this action's turn, as soon as those before it let it start."""
        self._entries[action_id] = replace(self[action_id], triggered=True)
        self._triggered.append(action_id)

    def update(self, action_id: str, status: ActionStatus, result: Optional[str] = None) -> None:
        """An action is farther. One that has ended stays as it is."""
        entry = self._entries.get(action_id)
        if entry is None or entry.status.has_ended:
            return
        self._entries[action_id] = replace(entry, status=status, result=result or entry.result)
        if status.has_ended and action_id in self._triggered:
            self._triggered.remove(action_id)

    # --- what may be done -------------------------------------------------------------------------

    def startable(self, standing: bool) -> Tuple[Entry, ...]:
        """Those that may start now: figure 17, going on while earlier ones run."""
        result: List[Entry] = []
        busy = False
        for action_id in self._triggered:
            entry = self[action_id]
            kind = entry.action.blocking_type
            if kind.forbids_others and busy:
                break
            busy = True
            if not entry.is_active and (standing or not kind.forbids_driving):
                result.append(entry)
            if kind.forbids_others:
                break
        return tuple(result)

    @property
    def forbid_driving(self) -> bool:
        """Whether a triggered action needs the vehicle to stand."""
        return any(self[action_id].forbids_driving for action_id in self._triggered)

    def stops_at(self, *sequence_ids: int) -> bool:
        """Whether one of these elements has an action for which the vehicle must stand."""
        return any(entry.forbids_driving for entry in self.entries
                   if entry.sequence_id in sequence_ids)

    def of(self, sequence_id: int) -> Sequence[Entry]:
        """The actions of a node or edge."""
        return [entry for entry in self.entries if entry.sequence_id == sequence_id]

    @property
    def order_has_ended(self) -> bool:
        """Whether no action of the order is left to be done."""
        return all(entry.status.has_ended for entry in self.entries if entry.belongs_to_order)
