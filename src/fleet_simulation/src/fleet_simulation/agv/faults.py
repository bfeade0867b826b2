"""Faults of AGVs, each requested by one line of text. The table of faults also yields the help
text.
"""
from __future__ import annotations

import math
from typing import Callable, Dict, List, NamedTuple, Sequence

from fleet_simulation.agv.vehicle import AgvVehicle
from route_protocol.order_rules import RouteRefused
from route_protocol.steps import Word
from route_protocol.values import Reason, ReasonCode
from trajectory_graph import UnknownVertex

ON_DEMAND = Reason(ReasonCode.OTHER, 'fault on demand')


class UnknownAgvFault(ValueError):
    """A line is not a valid fault. The text is a sentence that says why."""


class FaultArgument(NamedTuple):
    """A number that follows the word of a fault."""

    name: str
    minimum: float
    maximum: float
    default: float


class AgvFault(NamedTuple):
    """The effect of a word; `act` gets the vehicle and the arguments as numbers."""

    meaning: str
    arguments: Sequence[FaultArgument]
    act: Callable[..., None]


_SECONDS = FaultArgument('SECONDS', 0.0, 1e6, math.inf)
_COUNT = FaultArgument('COUNT', 1.0, 1000.0, 1.0)

FAULTS: Dict[str, AgvFault] = {
    'stall': AgvFault('brakes and stands still for SECONDS (10); its route stays active',
                      [_SECONDS._replace(default=10.0)], AgvVehicle.stall),
    'slow': AgvFault('drives with FACTOR of its speed for SECONDS (for ever)',
                     [FaultArgument('FACTOR', 0.01, 1.0, 0.5), _SECONDS], AgvVehicle.slow_down),
    'silence': AgvFault('neither receives nor reports for SECONDS (for ever); 0 ends it',
                        [_SECONDS], AgvVehicle.fall_silent),
    'leave': AgvFault('is switched off', [], AgvVehicle.leave),
    'join': AgvFault('is switched on, without memory of its route', [], AgvVehicle.join),
    'fail': AgvFault('its route fails', [], lambda vehicle: vehicle.fail(ON_DEMAND)),
    'takeover': AgvFault('another program drives it: its route fails with "taken over"', [],
                         AgvVehicle.take_over),
    'drive_by_hand': AgvFault('another program drives it to the end of EDGE; its route fails',
                              [FaultArgument('EDGE', -2 ** 31, 2 ** 31, math.nan)],
                              lambda vehicle, edge: vehicle.drive_by_hand(int(edge))),
    'estop': AgvFault('emergency stop: brakes hard, the route fails', [],
                      AgvVehicle.press_emergency_stop),
    'release': AgvFault('ends the emergency stop', [], AgvVehicle.release_emergency_stop),
    'offgraph': AgvFault('is pushed METRES (1) to its left, off every edge; its route fails',
                         [FaultArgument('METRES', -100.0, 100.0, 1.0)], AgvVehicle.push_off_graph),
    'place': AgvFault('is put onto VERTEX', [FaultArgument('VERTEX', 1, 2 ** 31, math.nan)],
                      lambda vehicle, vertex: vehicle.put_on(int(vertex))),
    'battery': AgvFault('has PERCENT of charge', [FaultArgument('PERCENT', 0.0, 100.0, math.nan)],
                        lambda vehicle, percent: setattr(vehicle.battery, 'charge', percent)),
    'step_fails': AgvFault('the next COUNT (1) steps fail', [_COUNT],
                        lambda vehicle, count: vehicle.steps.fail_next(Word.FAILED, int(count))),
    'step_unknown': AgvFault('the next COUNT (1) steps are done, but the AGV cannot tell', [_COUNT],
                          lambda vehicle, count: vehicle.steps.fail_next(Word.UNKNOWN,
                                                                         int(count))),
    'step_hangs': AgvFault('the next COUNT (1) steps never end', [_COUNT],
                        lambda vehicle, count: vehicle.steps.fail_next(Word.RUNNING, int(count))),
    'step_driver': AgvFault('the driver of its steps is restarted: what runs is broken off', [],
                         lambda vehicle: vehicle.steps.restart()),
}


def inject(vehicle: AgvVehicle, line: str) -> None:
    """Injects the fault that a line describes, e.g. `stall 20`. Raises UnknownAgvFault."""
    word, *given = line.split() or ['']
    fault = FAULTS.get(word.lower())
    if fault is None:
        raise UnknownAgvFault(f"there is no fault '{word[:20]}'; there are: {', '.join(FAULTS)}")
    if len(given) > len(fault.arguments):
        raise UnknownAgvFault(f'{word} takes {len(fault.arguments)} numbers, not {len(given)}')
    try:
        fault.act(vehicle, *_numbers(word, fault.arguments, given))
    except (UnknownVertex, RouteRefused) as error:
        raise UnknownAgvFault(str(error)) from None


def help_text() -> str:
    """Returns the help text: all faults, one per line."""
    lines = []
    for word, fault in FAULTS.items():
        usage = ' '.join([word, *(argument.name if math.isnan(argument.default)
                                  else f'[{argument.name}]' for argument in fault.arguments)])
        lines.append(f'{usage:<22}{fault.meaning}')
    return '\n'.join(lines)


def _numbers(word: str, arguments: Sequence[FaultArgument], given: Sequence[str]) -> List[float]:
    numbers = []
    for argument, text in zip(arguments, [*given, *[''] * len(arguments)]):
        try:
            value = float(text) if text else argument.default
        except ValueError:
            value = math.nan
        if not (argument.minimum <= value <= argument.maximum
                or (not text and value == argument.default)):
            raise UnknownAgvFault(f'{word}: {argument.name} must be a number from '
                                  f'{argument.minimum:g} to {argument.maximum:g}')
        numbers.append(value)
    return numbers
