"""Actions from their reception to their end: what waits, what may start, what holds the vehicle.

Actions are triggered in the order in which their nodes and edges are reached; figure 17 of the
standard says which of them may run beside each other, and which need the vehicle to stand.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import Callable, Collection, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

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

    @cached_property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand for it, once it is triggered and until it has ended."""
        return self.action.blocking_type.forbids_driving and not self.status.has_ended

    @cached_property
    def state(self) -> ActionState:
        """What the master is told."""
        return ActionState(self.action.action_id, self.action.action_type, self.status,
                           self.action.description, self.result, not self.belongs_to_order)


@dataclass(frozen=True)
class ActionQueue:
    """All actions that the state tells of, by id, as they came.

    triggered -- ids of those triggered and not ended, in the order in which they are to run
    """

    by_id: Mapping[str, Entry] = field(default_factory=dict)
    triggered: Tuple[str, ...] = ()

    def __contains__(self, action_id: str) -> bool:
        return action_id in self.by_id

    def __getitem__(self, action_id: str) -> Entry:
        return self.by_id[action_id]

    def __iter__(self) -> Iterator[Entry]:
        return iter(self.by_id.values())

    @cached_property
    def states(self) -> Tuple[ActionState, ...]:
        """What the master is told."""
        return tuple(entry.state for entry in self)

    # --- coming and going -------------------------------------------------------------------------

    def with_entries(self, *new: Entry) -> ActionQueue:
        """With actions that came."""
        entries: Dict[str, Entry] = {**self.by_id,
                                     **{entry.action.action_id: entry for entry in new}}
        for action_id in _ended_instant_actions(entries.values())[:-MAX_ENDED_INSTANT_ACTIONS]:
            del entries[action_id]
        return replace(self, by_id=entries)

    @property
    def is_full(self) -> bool:
        """Whether the oldest of the instant actions that have ended is forgotten next."""
        return len(_ended_instant_actions(self)) >= MAX_ENDED_INSTANT_ACTIONS

    def without_order(self, keep_instant: bool = False) -> ActionQueue:
        """Without the order's, and instant actions that have ended unless they are kept."""
        return self._with_those(lambda entry: not entry.belongs_to_order and (
            keep_instant or not entry.status.has_ended))

    def without_ended_instant_actions(self) -> ActionQueue:
        """Without instant actions that have ended."""
        return self._with_those(
            lambda entry: entry.belongs_to_order or not entry.status.has_ended)

    def without(self, sequence_ids: Collection[int]) -> ActionQueue:
        """Without the actions of a horizon that is replaced."""
        return self._with_those(lambda entry: entry.sequence_id not in sequence_ids)

    def _with_those(self, are_kept: Callable[[Entry], bool]) -> ActionQueue:
        kept = {name: entry for name, entry in self.by_id.items() if are_kept(entry)}
        return ActionQueue(kept, tuple(name for name in self.triggered if name in kept))

    def with_element_triggered(self, sequence_id: int) -> ActionQueue:
        """After the node was passed, or the edge entered."""
        return self.with_triggered(*(
            entry.action.action_id for entry in self.of(sequence_id)
            if not entry.triggered and not entry.status.has_ended))

    def with_triggered(self, *action_ids: str) -> ActionQueue:
        """It is the turn of these actions, as soon as those before let them start."""
        if not action_ids:
            return self
        now = {name: replace(self[name], triggered=True) for name in action_ids}
        return ActionQueue({**self.by_id, **now}, self.triggered + action_ids)

    def updated(self, action_id: str, status: ActionStatus,
                result: Optional[str] = None) -> ActionQueue:
        """With an action that is farther. One that has ended stays as it is."""
        entry = self.by_id.get(action_id)
        if entry is None or entry.status.has_ended:
            return self
        entry = replace(entry, status=status, result=result or entry.result)
        return ActionQueue({**self.by_id, action_id: entry}, tuple(
            name for name in self.triggered if name != action_id or not status.has_ended))

    # --- what may be done -------------------------------------------------------------------------

    def startable(self, standing: bool) -> Tuple[Entry, ...]:
        """Those that may start now: figure 17, going on while earlier ones run."""
        result: List[Entry] = []
        busy = False
        for action_id in self.triggered:
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
        return any(self[action_id].forbids_driving for action_id in self.triggered)

    @property
    def hold_the_robot(self) -> bool:
        """Whether an action runs for which the vehicle stands, or which moves it by itself."""
        return any(self[name].is_active and self[name].forbids_driving for name in self.triggered)

    def next_stop(self, after: int) -> Optional[int]:
        """The first element behind this one with an action for which the vehicle must stand."""
        return min((entry.sequence_id for entry in self
                    if entry.sequence_id > after and entry.forbids_driving), default=None)

    def of(self, sequence_id: int) -> List[Entry]:
        """The actions of a node or edge."""
        return [entry for entry in self if entry.sequence_id == sequence_id]

    @cached_property
    def order_has_ended(self) -> bool:
        """Whether no action of the order is left to be done."""
        return all(entry.status.has_ended for entry in self if entry.belongs_to_order)


def _ended_instant_actions(entries: Iterable[Entry]) -> List[str]:
    return [entry.action.action_id for entry in entries
            if not entry.belongs_to_order and entry.status.has_ended]
