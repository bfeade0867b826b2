"""The names and words of FLOW Core's Integration Toolkit (REST), in one table.

Sources: docs/explanation/sources.md. Only the REST server uses this table. It shares no word with
the table of ARCL (`job_words`), so that a mistake in one table shows as a difference.
"""
from __future__ import annotations

from enum import Enum
from typing import Dict, Mapping, Tuple

from omron_jobs.core.job_words import RobotStatus, SegmentKind, SegmentStatus

USER = 'toolkitadmin'
BY, BY_KEY, UPDATED_SINCE, HISTORY, STREAM = 'By', 'ByKey', 'UpdatedSince', 'History', 'Stream'
SINCE, KEY = 'sinceTime', 'namekey'


class RestType(Enum):
    """A type of records. The value is the first part of its paths."""

    JOB_REQUEST = 'JobRequest'
    PICKUP = 'Pickup'
    DROPOFF = 'Dropoff'
    PICKUP_DROPOFF = 'PickupDropoff'
    JOB_CANCEL = 'JobCancel'
    JOB_SEGMENT_MODIFY = 'JobSegmentModify'
    JOB = 'Job'
    JOB_SEGMENT = 'JobSegment'
    ROBOT = 'Robot'
    ROBOT_FAULT = 'RobotFault'
    GOAL = 'Goal'
    STORE_ITEM = 'DataStoreItem'
    STORE_VALUE = 'DataStoreValue'


LATEST = 'DataStoreValueLatest'
REQUESTS = (RestType.JOB_REQUEST, RestType.PICKUP, RestType.DROPOFF, RestType.PICKUP_DROPOFF)
"""Types of records that request a job."""
AUDITED = (*REQUESTS, RestType.JOB_CANCEL, RestType.JOB_SEGMENT_MODIFY)
"""Types of records that clients post. They have the field `audit`; the other types have `upd`."""
WITH_HISTORY = (RestType.JOB, RestType.JOB_SEGMENT, RestType.ROBOT, RestType.ROBOT_FAULT)

_OF_REQUESTS = ('jobId', 'status', 'assignedJobId')
FILTERS: Dict[RestType, Tuple[str, ...]] = {
    RestType.JOB_REQUEST: _OF_REQUESTS,
    RestType.PICKUP: _OF_REQUESTS,
    RestType.DROPOFF: (*_OF_REQUESTS, 'robot'),
    RestType.PICKUP_DROPOFF: _OF_REQUESTS,
    RestType.JOB_CANCEL: (),
    RestType.JOB_SEGMENT_MODIFY: ('segmentId',),
    RestType.JOB: ('jobId', 'lastAssignedRobot', 'status'),
    RestType.JOB_SEGMENT: ('status', 'job', 'robot', 'goalName'),
    RestType.ROBOT: ('status', 'subStatus'),
    RestType.ROBOT_FAULT: ('robot', 'type', 'name', 'active'),
    RestType.GOAL: (),
    RestType.STORE_ITEM: ('groupName', 'itemName'),
    RestType.STORE_VALUE: (),
}
"""The fields by which records can be queried: `/X/By<Field>/{value}`."""

NOT_OFFERED: Mapping[str, str] = {
    'WaitTaskCancel': 'robots of this fleet wait in the steps of missions: use a step of an '
                      'outside program',
    'WaitTaskState': 'robots of this fleet wait in the steps of missions: see "mission list"',
    'SubscriptionConfig': 'there is no database and no message queue whose content it would choose',
}
"""Types of FLOW Core that this server does not have, and why."""


class JobStatus(Enum):
    """The status of a job, and of the request for it."""

    PENDING = 'Pending'
    IN_PROGRESS = 'InProgress'
    COMPLETED = 'Completed'
    CANCELLED = 'Cancelled'
    CANCELLING = 'Cancelling'
    MODIFYING = 'Modifying'


SEGMENT_STATUS: Mapping[SegmentStatus, str] = {
    SegmentStatus.PENDING: 'Pending',
    SegmentStatus.IN_PROGRESS: 'InProgress',
    SegmentStatus.INTERRUPTED: 'Interrupted',
    SegmentStatus.CANCELLING: 'Cancelling',
    SegmentStatus.COMPLETED: 'Completed',
    SegmentStatus.CANCELLED: 'Cancelled',
    SegmentStatus.FAILED: 'Failed',
    SegmentStatus.BEFORE_MODIFY: 'Modifying',
    SegmentStatus.INTERRUPTED_BY_MODIFY: 'InterruptedByModify',
    SegmentStatus.AFTER_MODIFY: 'Modified',
}
BEING_MODIFIED = (SegmentStatus.BEFORE_MODIFY, SegmentStatus.INTERRUPTED_BY_MODIFY,
                  SegmentStatus.AFTER_MODIFY)
FAILED = 'Failed'
"""The cancelReason of a job that has failed, because jobs have no such status."""
DONE = 'Completed'
"""The status of a cancellation or modification that was carried out."""
SEGMENT_TYPE: Mapping[SegmentKind, str] = {SegmentKind.PICKUP: 'Pickup',
                                           SegmentKind.DROPOFF: 'Dropoff'}
JOB_TYPE: Mapping[Tuple[SegmentKind, ...], str] = {
    (SegmentKind.PICKUP,): 'P', (SegmentKind.DROPOFF,): 'D',
    (SegmentKind.PICKUP, SegmentKind.DROPOFF): 'PD'}
MULTI = 'M'
ROBOT_STATUS: Mapping[RobotStatus, str] = {
    RobotStatus.AVAILABLE: 'Available', RobotStatus.IN_PROGRESS: 'InProgress',
    RobotStatus.UNAVAILABLE: 'UnAvailable'}


class CancelType(Enum):
    """The kind of thing that the value of a cancellation names."""

    SEGMENT_ID = 'SegmentId'
    JOB_ID = 'JobId'
    ROBOT_NAME = 'RobotName'
    STATUS = 'Status'
    SEGMENT_NAMEKEY = 'SegmentNamekey'
    JOB_NAMEKEY = 'JobNamekey'
    REMOVE_SEGMENT_ID = 'RemoveSegmentId'
    REMOVE_SEGMENT_NAMEKEY = 'RemoveSegmentNamekey'


SHORT_CANCELS: Mapping[str, CancelType] = {
    'robot': CancelType.ROBOT_NAME, 'jobNamekey': CancelType.JOB_NAMEKEY,
    'jobId': CancelType.JOB_ID}
"""Fields that replace the fields cancelType and cancelValue, and the type that each implies."""
