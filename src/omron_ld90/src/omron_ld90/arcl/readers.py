"""Readers of what stands behind a line's phrase, for the rows of the parser's table.

Each takes that text and gives the reply, or raises ValueError where the text does not fit.
"""
from __future__ import annotations

import math
import re
from functools import partial
from typing import Callable, Dict, List, Tuple

import numpy as np

from omron_ld90.arcl import replies as r
from omron_ld90.arcl.replies import Reply

Reader = Callable[[str], Reply]
Row = Tuple[str, Reader]

_COORDINATE_LIMIT = 2 ** 31  # ARCL's integers are signed 32 bit


def named(kind: Callable[[str], Reply]) -> Reader:
    """A name or text, which must be there."""
    def read(text: str) -> Reply:
        if not text:
            raise ValueError
        return kind(text)
    return read


def exactly(reply: Reply) -> Reader:
    """Nothing more: the phrase is the whole line."""
    def read(text: str) -> Reply:
        if text:
            raise ValueError
        return reply
    return read


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value) or '_' in text:
        raise ValueError
    return value


def measured(kind: Callable[[float], Reply]) -> Reader:
    """One number."""
    return lambda text: kind(_number(text))


def _numbers(text: str) -> List[float]:
    return [_number(word) for word in text.split()]


def location(text: str) -> r.Location:
    """`3120 -540 -87`: mm, mm, degrees."""
    x, y, heading = text.split()
    location = r.Location(float(x), float(y), float(heading))
    if not math.isfinite(location.x + location.y + location.heading) or '_' in text:
        raise ValueError
    return location


def temperature(text: str) -> r.Temperature:
    """Degrees Celsius; -127 and -128 stand for no sensor."""
    celsius = _number(text)
    return r.Temperature(None if celsius in (-127.0, -128.0) else celsius)


_STATUS_FIELDS: Dict[str, Row] = {
    'extendedstatusforhumans': ('extended_status', str),
    'status': ('status', str),
    'stateofcharge': ('state_of_charge', measured(r.StateOfCharge)),
    'batteryvoltage': ('battery_voltage', measured(r.BatteryVoltage)),
    'location': ('location', location),
    'localizationscore': ('localization_score', measured(r.LocalizationScore)),
    'temperature': ('temperature', temperature),
}
_STATUS_KEYWORD = re.compile(
    rf'(?:^| )({"|".join(_STATUS_FIELDS)}):(?: |$)', re.IGNORECASE)


def one_line_status(first: str) -> Reader:
    """Several status fields on one line, in any order. The status text may itself hold colons."""
    def read(text: str) -> Reply:
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
    return read


def docking(text: str) -> r.DockingStatus:
    """`Docked ForcedState: Unforced ChargeState: Float`."""
    words = text.split()
    state = r.DockingState(words[0].capitalize()) if words else None
    fields = dict(zip((word.lower() for word in words[1::2]), words[2::2]))
    if state is None or not set(fields) <= {'forcedstate:', 'chargestate:'}:
        raise ValueError
    return r.DockingStatus(state, fields.get('forcedstate:', '').lower() == 'forced',
                           fields.get('chargestate:', ''))


def estop(text: str) -> r.EStop:
    """`pressed`, `relieved but motors still disabled`, `pressed, cannot enable motors`."""
    word = text.split(' ', 1)[0].rstrip(',').lower()
    if word not in ('pressed', 'relieved'):
        raise ValueError
    return r.EStop(word == 'pressed', f'EStop {text}')


def to_point(reply: Reply) -> Reader:
    """`point`, perhaps with coordinates; a goal may be called `point 7`, but not `point 1 2`."""
    def read(text: str) -> Reply:
        if text and len(_numbers(text.replace(',', ' '))) not in (2, 3):
            raise ValueError
        return reply
    return read


def patrolling(text: str) -> r.Patrolling:
    """`<route>`, or `<route> once`."""
    if text.lower().endswith(' once'):
        return r.Patrolling(text[:-len(' once')], once=True)
    return named(partial(r.Patrolling, once=False))(text)


def instant_task(text: str) -> r.CompletedInstantTask:
    """The task; some robots put a colon before it."""
    return r.CompletedInstantTask(text.lstrip(': '))


_QUOTED_WORDS = re.compile(r'"([^"]*)"|(\S+)')


def _words(text: str) -> List[str]:
    return [quoted or bare for quoted, bare in _QUOTED_WORDS.findall(text)]


_TRUTH = {'true': True, 'false': False, '1': True, '0': False}


def fault(text: str, cleared: bool = False) -> r.Fault:
    """`<kind> <name> "<short>" "<long>" <driving> <critical> <application>`."""
    kind, name, short, long, *flags = _words(text)
    driving, critical, application = (_TRUTH.get(flag.lower(), False)
                                      for flag in (flags + ['', '', ''])[:3])
    return r.Fault(kind, name, short, long, driving, critical, application, cleared)


def odometer(text: str) -> r.Odometer:
    """`8281 mm 210 deg 469 sec`."""
    distance, _, rotation, _, seconds, _ = text.split()
    return r.Odometer(_number(distance), _number(rotation), _number(seconds))


def distance_between(text: str) -> r.DistanceBetween:
    """`<mm> "<goal>" "<goal>"`."""
    distance, origin, destination = _words(text)
    return r.DistanceBetween(_number(distance), origin, destination)


def map_object(text: str) -> r.MapObjectName:
    """`"<name>" <type>`."""
    name, kind, *_ = _words(text)
    return r.MapObjectName(name, kind)


def map_object_coord(text: str) -> r.MapObjectCoord:
    """`"<name>" -3914 1929 -90.000`: mm, mm, degrees."""
    name, x, y, heading = _words(text)
    return r.MapObjectCoord(name, _number(x), _number(y), _number(heading))


def config_value(text: str) -> r.ConfigValue:
    """`<key> <value>`."""
    key, _, value = text.partition(' ')
    return r.ConfigValue(key, value)


def digital_input(text: str, output: bool) -> r.Input:
    """`<name> on`."""
    name, _, state = text.rpartition(' ')
    return r.Input(name.strip('"'), state.lower(), output)


def range_device(text: str) -> r.RangeDevice:
    """`<name> <kind>`."""
    name, _, kind = text.partition(' ')
    return r.RangeDevice(name, kind)


def range_reading(text: str, cumulative: bool) -> r.RangeReading:
    """`<device> x y x y ...`: whole mm in the map frame; a dangling last number is dropped."""
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
    if numbers.max() >= _COORDINATE_LIMIT or numbers.min() < -_COORDINATE_LIMIT:
        raise ValueError
    return numbers


def localizing(done: bool, head: str) -> Reader:
    """Whatever follows: the wording varies between robots."""
    return lambda text: r.Localizing(done, f'{head} {text}'.strip())


def said(phrase: str, kind: Callable[[str], Reply] = r.Done) -> Row:
    """A row whose reply keeps the line as a whole."""
    return phrase, lambda text: kind(f'{phrase} {text}'.strip())


def item(prefix: str) -> Row:
    """A row for list items that are kept as text."""
    return f'{prefix}:', partial(r.Item, prefix)


def end(phrase: str) -> Row:
    """A row for the end of a list. The robot writes `End of x`, `EndOfX` and `EndX`."""
    what = re.sub(r'^end ?(of)? ?', '', phrase.lower())
    return phrase, exactly(r.EndOf(what))
