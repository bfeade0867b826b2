"""Readers of what stands behind a line's phrase, for the rows of the parser's table.

Each takes that text and gives the reply, or raises ValueError where the text does not fit.
"""
from __future__ import annotations

import math
import re
from functools import partial
from typing import Callable, Dict, List, Tuple

from omron_arcl.replies import driving, general, safety, site, status, tasks
from omron_arcl.replies.reply import Reply

Reader = Callable[[str], Reply]
Row = Tuple[str, Reader]


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


def location(text: str) -> status.Location:
    """`3120 -540 -87`: mm, mm, degrees."""
    x, y, heading = text.split()
    location = status.Location(float(x), float(y), float(heading))
    if not math.isfinite(location.x + location.y + location.heading) or '_' in text:
        raise ValueError
    return location


def temperature(text: str) -> status.Temperature:
    """Degrees Celsius; -127 and -128 stand for no sensor."""
    celsius = _number(text)
    return status.Temperature(None if celsius in (-127.0, -128.0) else celsius)


_STATUS_FIELDS: Dict[str, Row] = {
    'extendedstatusforhumans': ('extended_status', str),
    'status': ('status', str),
    'stateofcharge': ('state_of_charge', measured(status.StateOfCharge)),
    'batteryvoltage': ('battery_voltage', measured(status.BatteryVoltage)),
    'location': ('location', location),
    'localizationscore': ('localization_score', measured(status.LocalizationScore)),
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
        return status.OneLineStatus(**{'status': '', **fields})
    return read


def docking(text: str) -> driving.DockingStatus:
    """`Docked ForcedState: Unforced ChargeState: Float`."""
    words = text.split()
    state = driving.DockingState(words[0].capitalize()) if words else None
    fields = dict(zip((word.lower() for word in words[1::2]), words[2::2]))
    if state is None or not set(fields) <= {'forcedstate:', 'chargestate:'}:
        raise ValueError
    return driving.DockingStatus(state, fields.get('forcedstate:', '').lower() == 'forced',
                                 fields.get('chargestate:', ''))


def estop(text: str) -> safety.EStop:
    """`pressed`, `relieved but motors still disabled`, `pressed, cannot enable motors`."""
    word = text.split(' ', 1)[0].rstrip(',').lower()
    if word not in ('pressed', 'relieved'):
        raise ValueError
    return safety.EStop(word == 'pressed', f'EStop {text}')


def to_point(reply: Reply) -> Reader:
    """`point`, perhaps with coordinates; a goal may be called `point 7`, but not `point 1 2`."""
    def read(text: str) -> Reply:
        if text and len(_numbers(text.replace(',', ' '))) not in (2, 3):
            raise ValueError
        return reply
    return read


def patrolling(text: str) -> driving.Patrolling:
    """`<route>`, or `<route> once`."""
    if text.lower().endswith(' once'):
        return driving.Patrolling(text[:-len(' once')], once=True)
    return named(partial(driving.Patrolling, once=False))(text)


def instant_task(text: str) -> tasks.CompletedInstantTask:
    """The task; some robots put a colon before it."""
    return tasks.CompletedInstantTask(text.lstrip(': '))


_QUOTED_WORDS = re.compile(r'"([^"]*)"|(\S+)')


def split_words(text: str) -> List[str]:
    """The words of a line; one in double quotes may hold blanks."""
    return [quoted or bare for quoted, bare in _QUOTED_WORDS.findall(text)]


_TRUTH = {'true': True, 'false': False, '1': True, '0': False}


def fault(text: str, cleared: bool = False) -> safety.Fault:
    """`<kind> <name> "<short>" "<long>" <driving> <critical> <application>`."""
    kind, name, short, long, *flags = split_words(text)
    truths = [_TRUTH.get(flag.lower(), False) for flag in (flags + ['', '', ''])[:3]]
    return safety.Fault(kind, name, short, long, *truths, cleared=cleared)


def odometer(text: str) -> status.Odometer:
    """`8281 mm 210 deg 469 sec`."""
    distance, _, rotation, _, seconds, _ = text.split()
    return status.Odometer(_number(distance), _number(rotation), _number(seconds))


def distance_between(text: str) -> site.DistanceBetween:
    """`<mm> "<goal>" "<goal>"`."""
    distance, origin, destination = split_words(text)
    return site.DistanceBetween(_number(distance), origin, destination)


def map_object(text: str) -> site.MapObjectName:
    """`"<name>" <type>`."""
    name, kind, *_ = split_words(text)
    return site.MapObjectName(name, kind)


def map_object_coord(text: str) -> site.MapObjectCoord:
    """`"<name>" -3914 1929 -90.000`: mm, mm, degrees."""
    name, x, y, heading = split_words(text)
    return site.MapObjectCoord(name, _number(x), _number(y), _number(heading))


def key_and_value(kind: Callable[[str, str], Reply]) -> Reader:
    """`<key> <value>`; the value may be missing, or hold blanks."""
    def read(text: str) -> Reply:
        key, _, value = text.partition(' ')
        return named(lambda key: kind(key, value))(key)
    return read


def localizing(done: bool, head: str) -> Reader:
    """Whatever follows: the wording varies between robots."""
    return lambda text: driving.Localizing(done, f'{head} {text}'.strip())


def said(phrase: str, kind: Callable[[str], Reply] = general.Done) -> Row:
    """A row whose reply keeps the line as a whole."""
    return phrase, lambda text: kind(f'{phrase} {text}'.strip())


def item(prefix: str) -> Row:
    """A row for list items that are kept as text."""
    return f'{prefix}:', partial(general.Item, prefix)


def end(phrase: str) -> Row:
    """A row for the end of a list. The robot writes `End of x`, `EndOfX` and `EndX`."""
    what = re.sub(r'^end ?(of)? ?', '', phrase.lower())
    return phrase, exactly(general.EndOf(what))
