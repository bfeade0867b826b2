"""The robot's data store: named values in groups; some count from the last trip reset.

Names and forms come from ARCL manual I617-E-02 p. 110-119 and 244, from the guide to the vendor's
Python library (groups and fields of a real robot), and from public client programs (`RobotX`,
`TransVel`, `ModeStatus`, `BatteryStateOfCharge` ...). The names of a fleet manager's sums over its
robots begin with `Agg`; a robot's own values have the names without `Agg` (`ParkingTime`). A real
robot has about forty groups; the simulator has only the values that it knows. Distances are
assumed to be in m.
"""
from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Callable, Dict, List, Tuple

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.behaviour.state_times import StateTimes, Sum, WorkState
from omron_ld90_sim.devices.battery import ChargeState
from omron_ld90_sim.motion.kinematics import SimPose, normalise

DATE = '%a %b %d %H:%M:%S %Y'
DOUBLE, LONG, TEXT = 'Double', 'Long long', 'String'
RANGES = {DOUBLE: '0 inf', LONG: '0 9223372036854775807', TEXT: 'None None'}
ANY_SIGN = '-2147483648 2147483647'
HOUR = 3600.0
CHARGE_NUMBERS = {state: number for number, state in enumerate(ChargeState)}
JOB_COUNTS = ('CompletedJobs', 'CompletedJobSegments', 'CancelledJobs', 'CancelledJobSegments',
              'ModifiedJobSegments')
SEGMENT_COUNTS = ('CancelledInProgressJobSegments', 'FailedJobSegments', 'InterruptedJobSegments')
# the states in the order of the manual's list, and whether their distance is counted, too
STATES = (('DropOffDriving', True), ('PickupDriving', True), ('Parking', True), ('Docking', True),
          ('ForceDocking', True), ('Docked', False), ('ForceDocked', False), ('InFault', False),
          ('InEstop', False), ('After', False), ('Parked', False), ('Buffered', False))


@dataclass(frozen=True)
class StoredValue:
    """One value of the data store."""

    name: str
    type: str
    description: str
    read: Callable[[DataStore], object]
    range: str = ''         # minimum and maximum; empty: the limits of its type

    @property
    def info(self) -> str:
        """Its description in the form of `getDataStoreFieldInfo`."""
        return (f'{self.type} {self.name} Intermediate {self.range or RANGES[self.type]} '
                f'"{self.description}" "" ""')

    def text(self, store: DataStore) -> str:
        """Its present value in the form of ARCL."""
        value = self.read(store)
        return f'{value:.3f}' if self.type == DOUBLE else f'{value}'


@dataclass(frozen=True)
class Group:
    """Fields that belong together."""

    name: str
    description: str
    category: str
    fields: Tuple[StoredValue, ...]
    trip: bool = False      # whether a trip reset affects it


class DataStore:
    """The data store of one robot."""

    def __init__(self, robot: SimRobot, wall_time: Callable[[], time.struct_time]) -> None:
        self.robot, self.wall_time = robot, wall_time
        self.trip_start = wall_time()
        self._encoder_zero = robot.true_pose

    @property
    def times(self) -> StateTimes:
        """The robot's times in each state."""
        return self.robot.state_times

    def reset_trip(self) -> List[StoredValue]:
        """Begins a new trip. Returns the counters of the trip, without its date."""
        self.times.reset_trip()
        self.trip_start = self.wall_time()
        return [field for group in GROUPS.values() for field in group.fields
                if group.trip and field.name.startswith('Trip')]

    @property
    def encoder_pose(self) -> SimPose:
        """The pose that the wheels measure, relative to the pose at the start."""
        zero, here = self._encoder_zero, self.robot.true_pose
        turn = complex(math.cos(math.radians(zero.theta)), -math.sin(math.radians(zero.theta)))
        place = complex(here.x - zero.x, here.y - zero.y) * turn
        return SimPose(place.real, place.imag, normalise(here.theta - zero.theta))

    def speed(self) -> float:
        """Returns the speed in mm/s, negative when driving backwards."""
        base = self.robot.base
        return -base.speed if base.track is not None and base.track.reverse else base.speed


def _counts(names: Tuple[str, ...], trip: str = '') -> Tuple[StoredValue, ...]:
    """Returns counters of jobs. They stay 0, because a robot without a fleet manager gets no jobs.
    """
    return tuple(StoredValue(f'{trip}{name}', LONG, f'{name}, of the fleet manager\'s jobs',
                             lambda _: 0) for name in names)


def _state_fields(trip: str, spent: Callable[[DataStore, WorkState], Sum]
                  ) -> Tuple[StoredValue, ...]:
    """Returns the fields of the states in STATES: hours, and for some states also metres."""
    counted: Dict[str, WorkState] = {state.value: state for state in WorkState}

    def hours(name: str) -> Callable[[DataStore], object]:
        state = counted.get(name)
        return lambda store: spent(store, state)[0] / HOUR if state else 0.0

    def metres(name: str) -> Callable[[DataStore], object]:
        state = counted.get(name)
        return lambda store: spent(store, state)[1] / 1000.0 if state else 0.0

    fields = []
    for name, driving in STATES:
        fields.append(StoredValue(f'{trip}{name}Time', DOUBLE, f'Time in state {name} (hours)',
                                  hours(name)))
        if driving:
            fields.append(StoredValue(f'{trip}{name}Distance', DOUBLE, f'Way in state {name} (m)',
                                      metres(name)))
    return tuple(fields)


def _pose_fields(names: str, pose: Callable[[DataStore], SimPose]) -> Tuple[StoredValue, ...]:
    """Returns the fields X, Y (mm) and Th (deg) of a pose; `*` in `names` stands for the three."""
    x, y, theta = (names.replace('*', axis) for axis in ('X', 'Y', 'Th'))
    return (StoredValue(x, LONG, 'X (mm)', lambda store: round(pose(store).x), ANY_SIGN),
            StoredValue(y, LONG, 'Y (mm)', lambda store: round(pose(store).y), ANY_SIGN),
            StoredValue(theta, DOUBLE, 'Heading (deg)', lambda store: pose(store).theta,
                        '-180 180'))


def _robot_pose(store: DataStore) -> SimPose:
    return store.robot.pose


def _encoder_pose(store: DataStore) -> SimPose:
    return store.encoder_pose


_GROUPS = (
    Group('BatteryStateOfCharge', 'State of charge of the battery', 'Robot', (
        StoredValue('BatteryStateOfCharge', DOUBLE, 'State of charge (percent)',
                    lambda store: store.robot.docking.percent),)),
    Group('ChargingInfo', 'State of the charger', 'Robot', (
        StoredValue('RobotChargeState', TEXT, 'Phase of charging',
                    lambda store: store.robot.docking.charge.value),
        StoredValue('RobotChargeStateNumber', LONG, 'Phase of charging as a number',
                    lambda store: CHARGE_NUMBERS[store.robot.docking.charge]))),
    Group('DateAndTime', 'Date and time', 'Time', (
        StoredValue('DateAndTime', TEXT, 'Date and time',
                    lambda store: time.strftime(DATE, store.wall_time())),)),
    Group('EncoderPose', 'Pose from the wheels', 'Robot',
          _pose_fields('Encoder*', _encoder_pose)),
    Group('EncoderPoseInterpolated', 'Pose from the wheels, now', 'Robot',
          _pose_fields('EncoderPoseInterpolated_*', _encoder_pose)),
    Group('JobCounts', 'Counts of jobs', 'Queuing Statistics', _counts(JOB_COUNTS)),
    Group('LaserLocalization', 'Localization with the laser', 'Robot', (
        StoredValue('LaserLocalizationScore', LONG, 'Localization score (percent)',
                    lambda store: round(store.robot.localization.score * 100.0), '0 100'),)),
    Group('LastTripReset', 'The last trip reset', 'Time', (
        StoredValue('SecsSinceLastTripReset', LONG, 'Seconds since the last trip reset',
                    lambda store: int(store.times.trip_seconds)),
        StoredValue('DateAndTimeOfLastTripReset', TEXT, 'Date and time of the last trip reset',
                    lambda store: time.strftime(DATE, store.trip_start))), trip=True),
    Group('ModeInfo', 'What the robot is doing', 'Robot', (
        StoredValue('ModeStatus', TEXT, 'Status of the present mode',
                    lambda store: store.robot.status),)),
    Group('Path_Planning', 'Path planning', 'Robot', (
        StoredValue('Distance_to_goal', DOUBLE, 'Way left to the goal (mm)',
                    lambda store: store.robot.base.distance_left),)),
    Group('RobotPose', 'Pose of the robot', 'Robot', _pose_fields('Robot*', _robot_pose)),
    Group('RobotPoseInterpolated', 'Pose of the robot, now', 'Robot',
          _pose_fields('RobotPoseInterpolated_*', _robot_pose)),
    Group('SecondsSinceEpoch', 'Seconds since 1970', 'Time', (
        StoredValue('SecondsSinceEpoch', LONG, 'Seconds since 1970',
                    lambda store: int(time.mktime(store.wall_time()))),)),
    Group('SecondsSinceEpochMonotonic', 'Seconds since the start', 'Time', (
        StoredValue('SecondsSinceEpochMonotonic', LONG, 'Seconds since the start',
                    lambda store: int(store.robot.clock.now)),)),
    Group('StateInformation', 'Sums of states', 'Queuing Statistics',
          _counts(SEGMENT_COUNTS) + _state_fields(
              '', lambda store, state: store.times.total(state))),
    Group('TripJobCounts', 'Counts of jobs since the trip reset', 'Queuing Statistics',
          _counts(JOB_COUNTS, 'Trip'), trip=True),
    Group('TripStateInformation', 'Sums of states since the trip reset', 'Queuing Statistics',
          _counts(SEGMENT_COUNTS, 'Trip') + _state_fields(
              'Trip', lambda store, state: store.times.trip(state)), trip=True),
    Group('Velocities', 'Speeds of the robot', 'Robot', (
        StoredValue('TransVel', LONG, 'Speed, forwards positive (mm/s)',
                    lambda store: round(store.speed()), ANY_SIGN),)),
    Group('Versions', 'What the robot runs', 'Robot', tuple(
        StoredValue(name, TEXT, 'Version', lambda _: 'ld90_sim')
        for name in ('SNG', 'ARAM', 'MARC'))),
)

GROUPS: Dict[str, Group] = {group.name: group for group in _GROUPS}
FIELDS: Dict[str, StoredValue] = {field.name: field for group in _GROUPS for field in group.fields}
