"""The words of the standard that stand for one of a few things."""
from __future__ import annotations

from enum import Enum


class BlockingType(Enum):
    """What an action lets happen beside it; 2.x has no SINGLE."""

    NONE = 'NONE'      # driving and other actions
    SOFT = 'SOFT'      # other actions, no driving
    SINGLE = 'SINGLE'  # driving, no other actions
    HARD = 'HARD'      # nothing

    @property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand."""
        return self in (BlockingType.SOFT, BlockingType.HARD)

    @property
    def forbids_others(self) -> bool:
        """Whether no other action may run."""
        return self in (BlockingType.SINGLE, BlockingType.HARD)


class ActionStatus(Enum):
    """Life cycle of an action; 2.x has no RETRIABLE."""

    WAITING = 'WAITING'
    INITIALIZING = 'INITIALIZING'
    RUNNING = 'RUNNING'
    PAUSED = 'PAUSED'
    RETRIABLE = 'RETRIABLE'  # it failed, and the master says whether to try it again
    FINISHED = 'FINISHED'
    FAILED = 'FAILED'

    @property
    def has_ended(self) -> bool:
        """Whether it will not change any more."""
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)


class ErrorLevel(Enum):
    """How bad an error is; 2.x knows the first and the last."""

    WARNING = 'WARNING'
    URGENT = 'URGENT'
    CRITICAL = 'CRITICAL'
    FATAL = 'FATAL'


class ConnectionState(Enum):
    """Between vehicle and broker."""

    ONLINE = 'ONLINE'
    OFFLINE = 'OFFLINE'
    CONNECTION_BROKEN = 'CONNECTIONBROKEN'


class EStop(Enum):
    """How an emergency stop is acknowledged."""

    AUTOACK = 'AUTOACK'
    MANUAL = 'MANUAL'
    REMOTE = 'REMOTE'
    NONE = 'NONE'


class OperatingMode(Enum):
    """The party in control of the vehicle."""

    AUTOMATIC = 'AUTOMATIC'
    SEMIAUTOMATIC = 'SEMIAUTOMATIC'
    MANUAL = 'MANUAL'
    SERVICE = 'SERVICE'
    TEACHIN = 'TEACHIN'
