"""Functions that read the rest of a line after its first phrase; the parser's table names them.

Each reader takes this rest and returns the reply. It raises ValueError if the rest does not fit.
"""
from __future__ import annotations

import re
from functools import partial
from typing import Any, Callable, Dict, List, Tuple

from omron_arcl import replies
from omron_arcl.replies import Reply, coordinates

Reader = Callable[[str], Reply]
Row = Tuple[str, Reader]


def named(kind: Callable[[str], Reply]) -> Reader:
    """Returns a reader of a name or text that must not be empty. Quotes around the whole text are
    removed.
    """
    def read(text: str) -> Reply:
        if not text:
            raise ValueError
        return kind(unquoted(text))
    return read


def unquoted(text: str) -> str:
    """Returns `text` without the quotes around it: some robots put names in quotes."""
    inner = text[1:-1]
    return inner if text == f'"{inner}"' and inner and '"' not in inner else text


def exactly(reply: Reply) -> Reader:
    """Returns a reader that accepts only an empty rest: the phrase is the whole line."""
    def read(text: str) -> Reply:
        if text:
            raise ValueError
        return reply
    return read


def number(text: str, minimum: float = -1e15, maximum: float = 1e15) -> float:
    """Returns a decimal number within `minimum` and `maximum`; raises ValueError otherwise."""
    value = float(text)
    if not minimum <= value <= maximum or '_' in text:
        raise ValueError
    return value


# Limits of possible measurements. Other values are rejected. All limits fit into a float32.
_PERCENT = (0.0, 100.0)
_VOLTS = (0.0, 1000.0)
_SCORE = (0.0, 1.0)
_CELSIUS = (-150.0, 1000.0)
_FARTHEST = 1e10  # mm from the map's origin: 10,000 km
_MAXIMUM_DEGREES = 360.0


def measured(kind: Callable[[float], Reply], limits: Tuple[float, float]) -> Reader:
    """Returns a reader of one number within `limits`."""
    minimum, maximum = limits
    return lambda text: kind(number(text, minimum, maximum))


state_of_charge = measured(replies.StateOfCharge, _PERCENT)
battery_voltage = measured(replies.BatteryVoltage, _VOLTS)
localization_score = measured(replies.LocalizationScore, _SCORE)


def location(text: str) -> replies.Location:
    """Reads `3120 -540 -87`: mm, mm, degrees."""
    words = text.split()
    x, y, heading = map(float, words)
    if (not -_FARTHEST <= x <= _FARTHEST or not -_FARTHEST <= y <= _FARTHEST
            or not -_MAXIMUM_DEGREES <= heading <= _MAXIMUM_DEGREES or '_' in text):
        raise ValueError
    return replies.Location(x, y, heading)


def temperature(text: str) -> replies.Temperature:
    """Returns degrees Celsius; -127 and -128 mean that there is no sensor."""
    celsius = number(text, *_CELSIUS)
    return replies.Temperature(None if celsius in (-127.0, -128.0) else celsius)


STATUS_FIELDS: Dict[str, Tuple[str, Callable[[str], object]]] = {
    'extendedstatusforhumans': ('extended_status', str),
    'status': ('status', str),
    'stateofcharge': ('state_of_charge', state_of_charge),
    'batteryvoltage': ('battery_voltage', battery_voltage),
    'location': ('location', location),
    'localizationscore': ('localization_score', localization_score),
    'temperature': ('temperature', temperature),
}
_STATUS_KEYWORD = re.compile(
    rf'(?:^| )({"|".join(STATUS_FIELDS)}):(?: |$)', re.IGNORECASE)


def one_line_status(first: str) -> Reader:
    """Returns a reader of several status fields on one line, in any order. The status text may
    contain colons.

    A field with an impossible value counts as not sent; `OneLineStatus.ignored` has it.
    """
    def read(text: str) -> Reply:
        if ':' not in text:
            raise ValueError
        parts = _STATUS_KEYWORD.split(f'{first} {text}')[1:]
        if len(parts) < 4:
            raise ValueError
        fields: Dict[str, Any] = {'status': ''}
        ignored: List[str] = []
        for keyword, value in zip(parts[::2], parts[1::2]):
            name, read_field = STATUS_FIELDS[keyword.lower()]
            try:
                fields[name] = read_field(value.strip())
            except ValueError:
                ignored.append(f'{keyword}: {value.strip()}')
        return replies.OneLineStatus(**fields, ignored=tuple(ignored))
    return read


def docking(text: str) -> replies.DockingStatus:
    """Reads `Docked ForcedState: Unforced ChargeState: Float`."""
    words = text.split() or ['']
    state = replies.DockingState(words[0].capitalize())
    fields = dict(zip((word.lower() for word in words[1::2]), words[2::2]))
    return replies.DockingStatus(state, fields.get('forcedstate:', '').lower() == 'forced',
                                 fields.get('chargestate:', ''))


def estop(text: str) -> replies.EStop:
    """Reads `pressed`, `relieved but motors still disabled`, `pressed, cannot enable motors`."""
    words = text.lower().replace(',', ' ').split()
    if words[:1] == ['button']:
        del words[0]
    if words[:1] not in (['pressed'], ['relieved'], ['released']):
        raise ValueError
    return replies.EStop(words[0] == 'pressed', f'EStop {text}')


def to_point(reply: Reply) -> Reader:
    """Returns a reader of the text after `point`, which may be empty or have 2 or 3 coordinates.

    So a goal may be named `point 7`, but not `point 1 2`.
    """
    def read(text: str) -> Reply:
        if text and not coordinates(text):
            raise ValueError
        return reply
    return read


def patrolling(text: str) -> replies.Patrolling:
    """Reads `<route>`, or `<route> once`."""
    if text.lower().endswith(' once'):
        return replies.Patrolling(unquoted(text[:-len(' once')]), once=True)
    if not text:
        raise ValueError
    return replies.Patrolling(unquoted(text), once=False)


def instant_task(text: str) -> replies.CompletedInstantTask:
    """Returns the task; some robots put a colon before it."""
    return replies.CompletedInstantTask(text.lstrip(': '))


_QUOTED_WORDS = re.compile(r'"([^"]*)"|(\S+)')


def split_words(text: str) -> List[str]:
    """Returns the words of a line; a word in double quotes may contain blanks."""
    return [quoted or bare for quoted, bare in _QUOTED_WORDS.findall(text)]


_TRUTH = {'true': True, 'false': False, '1': True, '0': False}


def fault(text: str, cleared: bool = False) -> replies.Fault:
    """Reads `<kind> <name> "<short>" "<long>" <driving> <critical> <application>`."""
    kind, name, short, long, *flags = split_words(text)
    stops, critical, application = (_TRUTH.get(flag.lower(), False)
                                    for flag in (flags + ['', '', ''])[:3])
    return replies.Fault(kind, name, short, long, stops, critical, application, cleared)


def map_object_coord(text: str) -> replies.MapObjectCoord:
    """Reads `"<name>" -3914 1929 -90.000`: mm, mm, degrees."""
    name, x, y, heading = split_words(text)
    return replies.MapObjectCoord(name, number(x, -_FARTHEST, _FARTHEST),
                              number(y, -_FARTHEST, _FARTHEST),
                              number(heading, -_MAXIMUM_DEGREES, _MAXIMUM_DEGREES))


def key_and_value(kind: Callable[[str, str], Reply]) -> Reader:
    """Returns a reader of `<key> <value>`; the value may be missing, or contain blanks."""
    def read(text: str) -> Reply:
        key, _, value = text.partition(' ')
        return named(lambda key: kind(key, value))(key)
    return read


def localizing(done: bool, head: str) -> Reader:
    """Returns a reader that accepts any rest, because the wording differs between robots."""
    return lambda text: replies.Localizing(done, f'{head} {text}'.strip())


def said(phrase: str, kind: Callable[[str], Reply] = replies.Done) -> Row:
    """Returns a row whose reply keeps the whole line."""
    return phrase, lambda text: kind(f'{phrase} {text}'.strip())


def item(prefix: str) -> Row:
    """Returns a row for list items, which are kept as text."""
    return f'{prefix}:', partial(replies.Item, prefix)


def end(phrase: str) -> Row:
    """Returns a row for the end of a list. The robot writes `End of x`, `EndOfX` and `EndX`."""
    what = re.sub(r'^end ?(of)? ?', '', phrase.lower())
    return phrase, exactly(replies.EndOf(what))
