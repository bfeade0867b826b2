"""The words and lines of OMRON's Fleet Manager, in one table.

Sources: docs/explanation/sources.md. Warehouse programs split the lines at blanks, and read words
by their position. So every blank and quotation mark counts. Only the server uses this table: the
simulator and the drivers have tables of their own. So a mistake in one table shows as a difference.
"""
from __future__ import annotations

import time
from enum import Enum

PROMPT = 'Enter password:'
WELCOME = ('Welcome to the server.',
           "You can type 'help' at any time for the following help list.")
COMMANDS, END_OF_COMMANDS = 'Commands:', 'End of commands'
HELP = '{:>15}          {}'
CLOSING = 'Closing connection'
SHUTTING_DOWN = 'Shutting down server'
TOO_LONG = 'String too long'
UNKNOWN = 'Unknown command {}'
USAGE = 'usage: {} {}'
ERROR, ERROR_DESCRIPTION = 'CommandError: {}', 'CommandErrorDescription: {} {}'
SET_UP_ERROR = 'SetUpError: {} {}'
NONE, NO_DATE, NO_ECHO = 'None', 'None None', '""'
QUOTED = '"{}"'

QUEUED = ' with priority {} id {} and job_id {} successfully queued'
PICKUP_QUEUED = 'queuepickup goal "{}"' + QUEUED
PICKUP_DROPOFF_QUEUED = ('queuepickupdropoff goals "{}" and "{}" with priorities {} and {} ids {} '
                         'and {} job_id {} successfully queued')
MULTI_QUEUED = 'QueueMulti: goal "{}"' + QUEUED
LINKED = ' and linked to {}'
LINKED_TO_JOB = ' and linked to job_id {}'
END_OF_MULTI = 'EndQueueMulti'
CANCELLING = 'queuecancel cancelling "{}" "{}" "{}" "{}" from queue'
MODIFYING_PRIORITY = 'queuemodify modifying id {} priority {}'
MODIFYING_GOAL = 'queuemodify modifying id {} goal "{}"'

# The blank at the end makes 15 fields; a known client requires 15 of each such line.
UPDATE = 'QueueUpdate: {segment} {job} {priority} {state} Goal "{goal}" {robot} {dates} {fails} '
LISTED = ': {segment} {job} {priority} {state} Goal "{goal}" {robot} {dates} {echo} {fails}'
SHOW, QUERY = 'QueueShow' + LISTED, 'QueueQuery' + LISTED
ROBOT = 'QueueRobot: "{}" {} {} {}'
# The fields: the robot's name; type, name, short text and long text of the fault; whether the robot
# cannot drive, whether the fault is critical, whether an application raised it; the echo.
ROBOT_FAULT = 'RobotFaultQuery: "{}" {} {} "{}" "{}" true false {} {}'
END_OF_FAULTS = 'EndQueryFaults'
END_OF_SHOW, END_OF_SHOW_COMPLETED = 'EndQueueShow', 'EndQueueShowCompleted'
END_OF_QUERY, END_OF_SHOW_ROBOT = 'EndQueueQuery', 'EndQueueShowRobot'

DATE = '%m/%d/%Y %H:%M:%S'
DATE_TIME = 'DateTime: {}'
GOAL, END_OF_GOALS = 'Goal: {}', 'End of goals'
SECTION, END_OF_SECTIONS = 'GetConfigSectionList: {}', 'EndOfGetConfigSectionList'
SECTION_VALUE, END_OF_SECTION_VALUES = ('GetConfigSectionValue: {} {}',
                                        'EndOfGetConfigSectionValues')
GROUP, END_OF_GROUPS = 'GetDataStoreGroupList: {}', 'EndOfGetDataStoreGroupList'
GROUP_VALUE, END_OF_GROUP_VALUES = ('GetDataStoreGroupValues: {} {}',
                                    'EndOfGetDataStoreGroupValues')
END_OF_PAYLOADS, END_OF_SLOT_COUNT = 'EndPayloadQuery', 'EndPayloadSlotCount'
ECHO_TURNED = 'Echo turned {}.'


class SegmentKind(Enum):
    """The act of a robot at the goal of a segment. The id of the segment begins with the value."""

    PICKUP = 'PICKUP'
    DROPOFF = 'DROPOFF'


class SegmentStatus(Enum):
    """The status of a segment. No other words are sent, because a known client would fail.

    BEFORE_MODIFY, INTERRUPTED_BY_MODIFY and AFTER_MODIFY do not last: they are sent only while a
    segment is modified.
    """

    PENDING = 'Pending'
    IN_PROGRESS = 'InProgress'
    INTERRUPTED = 'Interrupted'
    CANCELLING = 'Cancelling'
    COMPLETED = 'Completed'
    CANCELLED = 'Cancelled'
    FAILED = 'Failed'
    BEFORE_MODIFY = 'BeforeModify'
    INTERRUPTED_BY_MODIFY = 'InterruptedByModify'
    AFTER_MODIFY = 'AfterModify'

    @property
    def is_final(self) -> bool:
        """Whether a segment with this status never changes again."""
        return self in (SegmentStatus.COMPLETED, SegmentStatus.CANCELLED, SegmentStatus.FAILED)


UNALLOCATED, ALLOCATED, DRIVING = 'UnAllocated', 'Allocated', 'Driving'
BEFORE = {SegmentKind.PICKUP: 'BeforePickup', SegmentKind.DROPOFF: 'BeforeDropoff'}
AFTER = {SegmentKind.PICKUP: 'AfterPickup', SegmentKind.DROPOFF: 'AfterDropoff'}
WAITS_FOR = 'ID_{}'
REFUSED_BY_FLEET = 'RefusedByFleet'


APPLICATION_FAULT = 'Fault_Driving_Application_'
"""The beginning of the substatus of a robot with a fault; the name of the fault follows."""


class RobotStatus(Enum):
    """The status of a robot."""

    AVAILABLE = 'Available'
    IN_PROGRESS = 'InProgress'
    UNAVAILABLE = 'UnAvailable'


def date(milliseconds: int) -> str:
    """Returns a moment (ms since 1970) in local time; NO_DATE for 0."""
    return time.strftime(DATE, time.localtime(milliseconds / 1000.0)) if milliseconds else NO_DATE


def printed(text: str) -> str:
    """Returns a client's text with `?` for characters that do not print, so it may be sent back."""
    return ''.join(one if one.isprintable() else '?' for one in text)
