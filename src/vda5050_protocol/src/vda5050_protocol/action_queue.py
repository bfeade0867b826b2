"""The actions from their reception to their end.

The queue knows which actions wait, which may start, and which require the vehicle to stand still.
An action is triggered when the vehicle reaches its node or edge. Figure 17 of the standard says
which actions may run at the same time, and which require the vehicle to stand still.

    status                   event                                       next status
    WAITING                  it is triggered, and figure 17 permits it   RUNNING
    RUNNING                  it fails, and may be tried again (3.0)      RETRIABLE
    RETRIABLE                the master says `retry`                     INITIALIZING
    INITIALIZING             figure 17 permits it                        RUNNING
    all that have not ended  it succeeds, fails, is cancelled or missed  FINISHED, FAILED

Invariants: an action that has ended does not change. Triggered actions start in the order in which
they were triggered. An action of an order is removed only with the order or its horizon.
"""
from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import Callable, Collection, Dict, Iterable, Iterator, List, Mapping, Optional, Tuple

from vda5050_protocol.values import ActionState, ActionStatus, VdaAction

# The largest number of ended instant actions in the state. In 2.x they are reported until the next
# order, in 3.0 until the master clears them.
MAX_ENDED_INSTANT_ACTIONS = 100
# The largest number of instant actions that have not ended; more are FAILED at once.
MAX_INSTANT_ACTIONS = 100


class Scope(Enum):
    """The origin of an action."""

    INSTANT = 'INSTANT'
    NODE = 'NODE'
    EDGE = 'EDGE'


@dataclass(frozen=True)
class QueuedAction:
    """An action and its progress.

    sequence_id -- the sequenceId of the node or edge of the action; -1 for an instant action
    triggered   -- whether the vehicle has passed the node or entered the edge of the action; an
                   instant action is triggered when it is received
    """

    action: VdaAction
    scope: Scope
    sequence_id: int = -1
    status: ActionStatus = ActionStatus.WAITING
    triggered: bool = False
    result: Optional[str] = None

    @property
    def is_active(self) -> bool:
        """Whether the action was started and has not ended.

        An INITIALIZING action is not active, because it waits for a new try.
        """
        return self.status in (ActionStatus.RUNNING, ActionStatus.PAUSED, ActionStatus.RETRIABLE)

    @property
    def belongs_to_order(self) -> bool:
        """Whether the action came with an order."""
        return self.scope is not Scope.INSTANT

    @cached_property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand still once the action is triggered; False after its end.
        """
        return self.action.blocking_type.forbids_driving and not self.status.has_ended

    @cached_property
    def state(self) -> ActionState:
        """The report of this action for the master."""
        return ActionState(self.action.action_id, self.action.action_type, self.status,
                           self.action.description, self.result, not self.belongs_to_order)


@dataclass(frozen=True)
class ActionQueue:
    """All actions that the state reports.

    by_id     -- the actions by id, in the sequence of their reception
    triggered -- ids of the triggered actions that have not ended, in the sequence of execution

    A queue is immutable: a method returns a changed queue, or a value computed from the queue.
    """

    by_id: Mapping[str, QueuedAction] = field(default_factory=dict)
    triggered: Tuple[str, ...] = ()

    def __contains__(self, action_id: str) -> bool:
        return action_id in self.by_id

    def __getitem__(self, action_id: str) -> QueuedAction:
        return self.by_id[action_id]

    def __iter__(self) -> Iterator[QueuedAction]:
        return iter(self.by_id.values())

    @cached_property
    def states(self) -> Tuple[ActionState, ...]:
        """The reports of all actions for the master."""
        return tuple(entry.state for entry in self)

    # --- adding and removing actions --------------------------------------------------------------

    def with_entries(self, *new: QueuedAction) -> ActionQueue:
        """Returns the queue with new actions; the oldest ended instant actions may be dropped."""
        entries: Dict[str, QueuedAction] = {**self.by_id,
                                            **{entry.action.action_id: entry for entry in new}}
        for action_id in _ended_instant_actions(entries.values())[:-MAX_ENDED_INSTANT_ACTIONS]:
            del entries[action_id]
        return replace(self, by_id=entries)

    @property
    def is_full(self) -> bool:
        """Whether the next ended instant action displaces the oldest ended one."""
        return len(_ended_instant_actions(self)) >= MAX_ENDED_INSTANT_ACTIONS

    @property
    def instant_actions_under_way(self) -> int:
        """The number of instant actions that have not ended."""
        return sum(not entry.belongs_to_order and not entry.status.has_ended for entry in self)

    def without_order(self, keep_instant: bool = False) -> ActionQueue:
        """Returns the queue without the actions of the order.

        keep_instant -- whether instant actions that have ended stay in the queue
        """
        return self._with_those(lambda entry: not entry.belongs_to_order and (
            keep_instant or not entry.status.has_ended))

    def without_ended_instant_actions(self) -> ActionQueue:
        """Returns the queue without the instant actions that have ended."""
        return self._with_those(
            lambda entry: entry.belongs_to_order or not entry.status.has_ended)

    def without_action(self, action_id: str) -> ActionQueue:
        """Returns the queue without the action of this id."""
        return self._with_those(lambda entry: entry.action.action_id != action_id)

    def without(self, sequence_ids: Collection[int]) -> ActionQueue:
        """Returns the queue without the actions of these nodes and edges (a replaced horizon)."""
        return self._with_those(lambda entry: entry.sequence_id not in sequence_ids)

    def _with_those(self, are_kept: Callable[[QueuedAction], bool]) -> ActionQueue:
        kept = {name: entry for name, entry in self.by_id.items() if are_kept(entry)}
        return ActionQueue(kept, tuple(name for name in self.triggered if name in kept))

    def with_element_triggered(self, sequence_id: int) -> ActionQueue:
        """Returns the queue after the vehicle passed the node or entered the edge."""
        return self.with_triggered(*(
            entry.action.action_id for entry in self.of(sequence_id)
            if not entry.triggered and not entry.status.has_ended))

    def with_triggered(self, *action_ids: str) -> ActionQueue:
        """Returns the queue with these actions triggered; they start when earlier actions permit.
        """
        if not action_ids:
            return self
        now = {name: replace(self[name], triggered=True) for name in action_ids}
        return ActionQueue({**self.by_id, **now}, self.triggered + action_ids)

    def updated(self, action_id: str, status: ActionStatus,
                result: Optional[str] = None) -> ActionQueue:
        """Returns the queue with a new status of an action; an ended action does not change."""
        entry = self.by_id.get(action_id)
        if entry is None or entry.status.has_ended:
            return self
        entry = replace(entry, status=status, result=result or entry.result)
        return ActionQueue({**self.by_id, action_id: entry}, tuple(
            name for name in self.triggered if name != action_id or not status.has_ended))

    # --- permitted steps --------------------------------------------------------------------------

    def startable(self, standing: bool) -> Tuple[QueuedAction, ...]:
        """Returns the actions that may start now, according to figure 17, even if others still
        run.
        """
        result: List[QueuedAction] = []
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
        """Whether a triggered action requires the vehicle to stand still."""
        return any(self[action_id].forbids_driving for action_id in self.triggered)

    @property
    def hold_the_robot(self) -> bool:
        """Whether an active action requires the vehicle to stand, or moves the vehicle itself."""
        return any(self[name].is_active and self[name].forbids_driving for name in self.triggered)

    def next_stop(self, after: int) -> Optional[int]:
        """Returns the first sequenceId after `after` with an action that forbids driving."""
        return min((entry.sequence_id for entry in self
                    if entry.sequence_id > after and entry.forbids_driving), default=None)

    def of(self, sequence_id: int) -> List[QueuedAction]:
        """Returns the actions of a node or edge."""
        return [entry for entry in self if entry.sequence_id == sequence_id]

    @cached_property
    def order_has_ended(self) -> bool:
        """Whether all actions of the order have ended."""
        return all(entry.status.has_ended for entry in self if entry.belongs_to_order)


def _ended_instant_actions(entries: Iterable[QueuedAction]) -> List[str]:
    return [entry.action.action_id for entry in entries
            if not entry.belongs_to_order and entry.status.has_ended]
