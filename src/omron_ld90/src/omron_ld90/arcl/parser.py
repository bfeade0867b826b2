"""From a line of the robot to a reply, by one table.

A row is a phrase that the line begins with and the builder of what follows it. The first row whose
phrase fits, and whose builder does not raise ValueError, wins; words are compared without case. A
line that fits no row is an UnknownLine. Nothing here raises, whatever the line holds.
"""
from __future__ import annotations

import math
import re
from functools import partial
from typing import Callable, Dict, List, Tuple

import numpy as np

from omron_ld90.arcl import replies as r
from omron_ld90.arcl.replies import Reply

Builder = Callable[[str], Reply]

_COORDINATE_LIMIT = 2 ** 31  # ARCL's integers are signed 32 bit


def parse_line(text: str) -> Reply:
    """The reply that a line (without its end) is."""
    line = text.strip()
    head, _, rest = line.partition(' ')
    for tail, length, build in _RULES.get(head.lower(), ()):
        if length:
            if rest[:length].lower() != tail or rest[length:length + 1] not in ('', ' '):
                continue
            payload = rest[length + 1:]
        else:
            payload = rest
        try:
            return build(payload)
        except ValueError:
            continue
    help_entry = _HELP_ENTRY.match(text)
    if help_entry:
        return r.HelpEntry(*help_entry.groups())
    return r.UnknownLine(text)


# %15s%10s%s: a name, ten blanks, what it does
_HELP_ENTRY = re.compile(r'\s*(\S+) {10}(.*)$')


# --- builders: the text after the phrase -> reply; ValueError where it does not fit --------------

def _named(kind: Callable[[str], Reply]) -> Builder:
    def build(text: str) -> Reply:
        if not text:
            raise ValueError
        return kind(text)
    return build


def _exactly(reply: Reply) -> Builder:
    def build(text: str) -> Reply:
        if text:
            raise ValueError
        return reply
    return build


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value) or '_' in text:
        raise ValueError
    return value


def _measured(kind: Callable[[float], Reply]) -> Builder:
    return lambda text: kind(_number(text))


def _numbers(text: str) -> List[float]:
    return [_number(word) for word in text.split()]


def _location(text: str) -> r.Location:
    x, y, heading = text.split()
    location = r.Location(float(x), float(y), float(heading))
    if not math.isfinite(location.x + location.y + location.heading) or '_' in text:
        raise ValueError
    return location


def _temperature(text: str) -> r.Temperature:
    celsius = _number(text)
    return r.Temperature(None if celsius in (-127.0, -128.0) else celsius)


_STATUS_FIELDS: Dict[str, Tuple[str, Builder]] = {
    'extendedstatusforhumans': ('extended_status', str),
    'status': ('status', str),
    'stateofcharge': ('state_of_charge', _measured(r.StateOfCharge)),
    'batteryvoltage': ('battery_voltage', _measured(r.BatteryVoltage)),
    'location': ('location', _location),
    'localizationscore': ('localization_score', _measured(r.LocalizationScore)),
    'temperature': ('temperature', _temperature),
}
_STATUS_KEYWORD = re.compile(
    rf'(?:^| )({"|".join(_STATUS_FIELDS)}):(?: |$)', re.IGNORECASE)


def _one_line_status(first: str) -> Builder:
    """Several status fields on one line, in any order. The status text may itself hold colons."""
    def build(text: str) -> Reply:
        if ':' not in text:
            raise ValueError
        parts = _STATUS_KEYWORD.split(f'{first} {text}')[1:]
        if len(parts) < 4:
            raise ValueError
        fields = {}
        for keyword, value in zip(parts[::2], parts[1::2]):
            name, read = _STATUS_FIELDS[keyword.lower()]
            fields[name] = read(value.strip())
        return r.OneLineStatus(**{'status': '', **fields})
    return build


def _docking(text: str) -> r.DockingStatus:
    words = text.split()
    state = r.DockingState(words[0].capitalize()) if words else None
    fields = dict(zip((word.lower() for word in words[1::2]), words[2::2]))
    if state is None or not set(fields) <= {'forcedstate:', 'chargestate:'}:
        raise ValueError
    return r.DockingStatus(state, fields.get('forcedstate:', '').lower() == 'forced',
                           fields.get('chargestate:', ''))


def _estop(text: str) -> r.EStop:
    word = text.split(' ', 1)[0].rstrip(',').lower()
    if word not in ('pressed', 'relieved'):
        raise ValueError
    return r.EStop(word == 'pressed', f'EStop {text}')


def _to_point(reply: Reply) -> Builder:
    """`point`, perhaps with coordinates; a goal may be called `point 7`, but not `point 1 2`."""
    def build(text: str) -> Reply:
        if text and len(_numbers(text.replace(',', ' '))) not in (2, 3):
            raise ValueError
        return reply
    return build


def _patrolling(text: str) -> r.Patrolling:
    if text.lower().endswith(' once'):
        return r.Patrolling(text[:-len(' once')], once=True)
    return _named(partial(r.Patrolling, once=False))(text)


def _instant_task(text: str) -> r.CompletedInstantTask:
    return r.CompletedInstantTask(text.lstrip(': '))


_QUOTED_WORDS = re.compile(r'"([^"]*)"|(\S+)')


def _words(text: str) -> List[str]:
    return [quoted or bare for quoted, bare in _QUOTED_WORDS.findall(text)]


_TRUTH = {'true': True, 'false': False, '1': True, '0': False}


def _fault(text: str, cleared: bool = False) -> r.Fault:
    kind, name, short, long, *flags = _words(text)
    driving, critical, application = (_TRUTH.get(flag.lower(), False)
                                      for flag in (flags + ['', '', ''])[:3])
    return r.Fault(kind, name, short, long, driving, critical, application, cleared)


def _odometer(text: str) -> r.Odometer:
    distance, _, rotation, _, seconds, _ = text.split()
    return r.Odometer(_number(distance), _number(rotation), _number(seconds))


def _distance_between(text: str) -> r.DistanceBetween:
    distance, origin, destination = _words(text)
    return r.DistanceBetween(_number(distance), origin, destination)


def _map_object(text: str) -> r.MapObjectName:
    name, kind, *_ = _words(text)
    return r.MapObjectName(name, kind)


def _map_object_coord(text: str) -> r.MapObjectCoord:
    name, x, y, heading = _words(text)
    return r.MapObjectCoord(name, _number(x), _number(y), _number(heading))


def _config_value(text: str) -> r.ConfigValue:
    key, _, value = text.partition(' ')
    return r.ConfigValue(key, value)


def _input(text: str, output: bool) -> r.Input:
    name, _, state = text.rpartition(' ')
    return r.Input(name.strip('"'), state.lower(), output)


def _range_device(text: str) -> r.RangeDevice:
    name, _, kind = text.partition(' ')
    return r.RangeDevice(name, kind)


def _range_reading(text: str, cumulative: bool) -> r.RangeReading:
    device, _, numbers = text.partition(' ')
    if not device:
        raise ValueError
    flat = _integers(numbers)
    points = flat[:flat.size // 2 * 2].reshape(-1, 2)
    points.setflags(write=False)
    return r.RangeReading(device, points, cumulative)


def _integers(text: str) -> np.ndarray:
    """Blank-separated integers, read at once by numpy.

    numpy stops silently at the first word that is no integer, so the text is checked before: only
    digits, blanks and signs, each sign after a blank and before a digit.
    """
    padded = f' {text} '.encode('ascii')
    if (padded.translate(None, b'0123456789 -') or b'- ' in padded
            or padded.count(b'-') != padded.count(b' -')):
        raise ValueError
    if not padded.strip():
        return np.empty(0, np.int64)
    numbers = np.fromstring(text, dtype=np.int64, sep=' ')
    if np.abs(numbers).max() >= _COORDINATE_LIMIT:
        raise ValueError
    return numbers


def _localizing(done: bool, head: str) -> Builder:
    return lambda text: r.Localizing(done, f'{head} {text}'.strip())


def _said(phrase: str, kind: Callable[[str], Reply] = r.Done) -> Tuple[str, Builder]:
    """A row whose reply keeps the line as a whole."""
    return phrase, lambda text: kind(f'{phrase} {text}'.strip())


def _item(prefix: str) -> Tuple[str, Builder]:
    return f'{prefix}:', partial(r.Item, prefix)


def _end(phrase: str) -> Tuple[str, Builder]:
    """A row for the end of a list. The robot writes `End of x`, `EndOfX` and `EndX`."""
    what = re.sub(r'^end ?(of)? ?', '', phrase.lower())
    return phrase, _exactly(r.EndOf(what))


# --- the table ------------------------------------------------------------------------------------

_TABLE: Tuple[Tuple[str, Builder], ...] = (
    # status (arcl.md 4)
    ('Location:', _location),
    ('RangeDeviceGetCurrent:', partial(_range_reading, cumulative=False)),
    ('RangeDeviceGetCumulative:', partial(_range_reading, cumulative=True)),
    ('StateOfCharge:', _measured(r.StateOfCharge)),
    ('BatteryVoltage:', _measured(r.BatteryVoltage)),
    ('LocalizationScore:', _measured(r.LocalizationScore)),
    ('Temperature:', _temperature),
    *((f'{word}:', _one_line_status(f'{word}:')) for word in (
        'Status', 'Location', 'StateOfCharge', 'BatteryVoltage', 'LocalizationScore',
        'Temperature')),
    ('Status:', r.StatusText),
    ('ExtendedStatusForHumans:', r.ExtendedStatus),
    ('DockingState:', _docking),
    # driving (5.1)
    ('Going to point', _to_point(r.GoingToPoint())),
    ('Going to', _named(r.GoingTo)),
    ('Arrived at point', _to_point(r.ArrivedAtPoint())),
    ('Arrived at', _named(r.ArrivedAt)),
    ('Failed going to', _named(r.FailedGoingTo)),
    ('Stopping', _exactly(r.Stopping())),
    ('Stopped', _exactly(r.Stopped())),
    ('Parking', _exactly(r.Parking(parked=False))),
    ('Parked', _exactly(r.Parking(parked=True))),
    ('Patrolling route', _patrolling),
    ('Finished patrolling route', _named(r.FinishedPatrolling)),
    ('Completed patrol,', lambda text: r.LapCompleted()),
    ('Interrupted:', r.Interrupted),
    ('Error:', r.RobotError),
    ('Localizing', _localizing(False, 'Localizing')),
    ('Localized', _localizing(True, 'Localized')),
    # emergency stop, motors, faults (3, 5.6)
    ('EStop', _estop),
    ('Motors enabled', _exactly(r.Motors(True))),
    ('Motors are enabled', _exactly(r.Motors(True))),
    ('Motors disabled', _exactly(r.Motors(False))),
    ('Fault:', _fault),
    ('FaultCleared:', partial(_fault, cleared=True)),
    ('FaultList:', _fault),
    ('ApplicationFaultQuery:', _fault),
    ('RobotFaultQuery:', _fault),
    ('RobotFault:', partial(r.Notice, 'RobotFault')),
    # errors (3)
    ('CommandError:', r.CommandError),
    ('CommandErrorDescription:', r.CommandErrorDescription),
    ('Unknown command', r.UnknownCommand),
    ('SetUpError:', r.SetUpError),
    # tasks, macros, lists (5.2)
    ('Will do task', _named(r.WillDoTask)),
    ('Doing task', _named(r.DoingTask)),
    ('Completed doing task', _named(r.CompletedTask)),
    ('Completed doing instant task', _instant_task),
    ('Completed doing instant task:', _instant_task),
    ('Executing macro', _named(r.ExecutingMacro)),
    ('Completed macro', _named(r.CompletedMacro)),
    ('Executing list', _exactly(r.ExecutingList())),
    ('Successfully finished task list', _exactly(r.FinishedList())),
    _said('List being cleared'), _said('Making new list'), _said('Added task'),
    ('WaitState:', r.WaitState),
    ('PauseTask:', r.PauseState),
    # queries (5.2 to 5.6, 6)
    ('Goal:', _named(r.Goal)),
    ('Route:', _named(r.Route)),
    ('Macro:', _named(r.Macro)),
    ('Odometer:', _odometer),
    ('DateTime:', r.DateTime),
    ('DistanceBetween:', _distance_between),
    ('MapObjectList:', _map_object),
    ('MapObjectInfoCoord:', _map_object_coord),
    ('GetConfigSectionValue:', _config_value),
    ('Input:', partial(_input, output=False)),
    ('Output:', partial(_input, output=True)),
    ('RangeDevice:', _range_device),
    *(_item(prefix) for prefix in (
        'InfoList', 'Info', 'MapObjectTypeList', 'MapObjectTypeInfoArgument', 'MapObjectInfo',
        'MapObjectInfoParams', 'GetConfigSectionList', 'GetConfigSectionInfo',
        'GetConfigSectionParamInfo', 'InputList', 'OutputList', 'AnalogInputList',
        'AnalogInputRaw', 'AnalogInputVoltage', 'RangeDeviceCurrentDrawingData',
        'RangeDeviceCumulativeDrawingData', 'GetDataStoreGroupList', 'GetDataStoreGroupValues',
        'GetDataStoreGroupInfo', 'GetDataStoreFieldList', 'GetDataStoreFieldValues',
        'GetDataStoreFieldInfo', 'tripReset', 'PayloadQuery', 'PayloadQueryLocal',
        'PayloadSlotCount', 'QueueShow', 'QueueRobot', 'QueueQuery', 'QueueMulti')),
    ('Routes', _exactly(r.Item('Routes', ''))),
    ('Commands:', _exactly(r.Item('Commands', ''))),
    *(_end(phrase) for phrase in (
        'End of goals', 'End of routes', 'End of macros', 'End of commands', 'End of info list',
        'End of MapObjectTypeList', 'End of MapObjectTypeInfo', 'End of MapObjectList',
        'End of MapObjectInfo', 'EndOfGetConfigSectionList', 'EndOfGetConfigSectionValues',
        'EndOfGetConfigSectionInfo', 'End of ApplicationFaultQuery', 'End of FaultList',
        'EndQueryFaults', 'End of InputList', 'End of OutputList', 'End of AnalogInputList',
        'EndOfRangeDeviceList', 'EndExtIODump', 'EndOfGetDataStoreGroupList',
        'EndOfGetDataStoreGroupValues', 'EndOfGetDataStoreGroupInfo',
        'EndOfGetDataStoreFieldList', 'EndOfGetDataStoreFieldValues',
        'EndOfGetDataStoreFieldInfo', 'EndOfTripReset', 'EndPayloadQuery',
        'EndQueueShow', 'EndQueueQuery')),
    # said once it is done, or said to everybody (5.3 to 5.7, 7)
    ('Map changed', _exactly(r.MapChanged())),
    ('Configuration changed', _exactly(r.ConfigurationChanged())),
    ('Config had errors parsing:', r.ConfigErrors),
    *(_said(phrase) for phrase in (
        'Reset odometer', 'Created info for', 'Updated info for', 'New config starting', 'Added',
        'Will parse config', 'Config parsed fine', 'Will add new param',
        'Will add config comment', 'ApplicationFaultSet set', 'ApplicationFaultClear cleared',
        'Saying', 'Playing', 'Logging', 'Creating simple popup', 'Outgoing connected to')),
    ('Echo is on.', _exactly(r.Echo(True))),
    ('Echo is off.', _exactly(r.Echo(False))),
    ('Echo turned on.', _exactly(r.Echo(True))),
    ('Echo turned off.', _exactly(r.Echo(False))),
    *((f'{kind}:', partial(r.Notice, kind)) for kind in (
        'QueueUpdate', 'PayloadUpdate', 'extIOInputUpdate', 'extIOOutputUpdate')),
    ('queuedropoff', partial(r.Notice, 'queueDropoff')),
    ('TextRequestChargeVoltage', partial(r.Notice, 'Charge')),
    ('Charge requested', partial(r.Notice, 'Charge')),
    ('Teleop driving', partial(r.Notice, 'Teleop')),
    ('Robot lost', _exactly(r.Notice('Lost', ''))),
    ('Driving', partial(r.Notice, 'Driving')),
    ('Following', partial(r.Notice, 'Following')),
    _said('Shutting down', r.ServerClosing),
    _said('Closing connection', r.ServerClosing),
)


def _index(table: Tuple[Tuple[str, Builder], ...]) -> Dict[str, List[Tuple[str, int, Builder]]]:
    """The table by first word, so that a line meets only the few rows it can fit."""
    rules: Dict[str, List[Tuple[str, int, Builder]]] = {}
    for phrase, build in table:
        head, _, tail = phrase.lower().partition(' ')
        rules.setdefault(head, []).append((tail, len(tail), build))
    return rules


_RULES = _index(_TABLE)
