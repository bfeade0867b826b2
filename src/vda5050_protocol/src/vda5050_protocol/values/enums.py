"""The enumerations of the standard."""
from __future__ import annotations

from enum import Enum


class BlockingType(Enum):
    """What an action permits while it runs; 2.x has no SINGLE."""

    NONE = 'NONE'      # driving and other actions
    SOFT = 'SOFT'      # other actions, no driving
    SINGLE = 'SINGLE'  # driving, no other actions
    HARD = 'HARD'      # neither driving nor other actions

    @property
    def forbids_driving(self) -> bool:
        """Whether the vehicle must stand still."""
        return self in (BlockingType.SOFT, BlockingType.HARD)

    @property
    def forbids_others(self) -> bool:
        """Whether no other action may run."""
        return self in (BlockingType.SINGLE, BlockingType.HARD)


class ActionStatus(Enum):
    """The life cycle of an action; 2.x has no RETRIABLE."""

    WAITING = 'WAITING'
    INITIALIZING = 'INITIALIZING'
    RUNNING = 'RUNNING'
    PAUSED = 'PAUSED'
    RETRIABLE = 'RETRIABLE'  # the action failed; the master decides whether to retry it
    FINISHED = 'FINISHED'
    FAILED = 'FAILED'

    @property
    def has_ended(self) -> bool:
        """Whether the status is final."""
        return self in (ActionStatus.FINISHED, ActionStatus.FAILED)


class ErrorLevel(Enum):
    """The severity of an error; 2.x has only WARNING and FATAL."""

    WARNING = 'WARNING'
    URGENT = 'URGENT'
    CRITICAL = 'CRITICAL'
    FATAL = 'FATAL'


class ConnectionState(Enum):
    """The connection between vehicle and broker."""

    ONLINE = 'ONLINE'
    OFFLINE = 'OFFLINE'
    CONNECTION_BROKEN = 'CONNECTIONBROKEN'


class EmergencyStop(Enum):
    """How an emergency stop is acknowledged."""

    AUTOACK = 'AUTOACK'
    MANUAL = 'MANUAL'
    REMOTE = 'REMOTE'
    NONE = 'NONE'


class OperatingMode(Enum):
    """The operating mode, which says whether the master or a person controls the vehicle."""

    AUTOMATIC = 'AUTOMATIC'
    SEMIAUTOMATIC = 'SEMIAUTOMATIC'
    MANUAL = 'MANUAL'
    SERVICE = 'SERVICE'
    TEACHIN = 'TEACHIN'
