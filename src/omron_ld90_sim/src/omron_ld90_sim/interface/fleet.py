"""`--robots FILE`: several robots on one map, in YAML.

    robots:
    - {name: r1, port: 7171, outgoing: "127.0.0.1:7179", start: [1.0, 2.0, 90]}
    - {name: r2, port: 7181}

`outgoing` and `start` (metres, metres, degrees) are optional. A robot without `start` begins at
the next free dock, goal or place.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import yaml

from omron_ld90_sim.interface.numbers import percent, start_pose


class FleetError(ValueError):
    """The file describes no fleet; the text names the robot and the field."""


@dataclass(frozen=True)
class RobotSpec:
    """One robot of a simulation."""

    name: str = 'robot'
    port: int = 0
    outgoing: Optional[Tuple[str, int]] = None
    start: Optional[Tuple[float, float, float]] = None     # mm, mm, degrees
    battery: float = 100.0


def address(text: str) -> Tuple[str, int]:
    """Reads `HOST:PORT`; raises ValueError for another text."""
    host, _, port = str(text).rpartition(':')
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise ValueError(f"'{text}' is not HOST:PORT")
    return host, int(port)


def read_fleet(path: str) -> List[RobotSpec]:
    """Returns the robots of a file; raises FleetError if it is malformed."""
    try:
        with open(path, encoding='utf-8') as file:
            content = yaml.safe_load(file)
    except OSError as error:
        raise FleetError(f'{path}: cannot be read ({error.strerror})') from error
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise FleetError(f'{path}: is not YAML ({str(error).splitlines()[0]})') from error
    rows = content.get('robots') if isinstance(content, dict) else None
    if not isinstance(rows, list) or not rows:
        raise FleetError(f'{path}: expected a list "robots" with at least one robot')
    specs = [_spec(path, number, row) for number, row in enumerate(rows, 1)]
    for field in ('name', 'port'):
        values = [getattr(spec, field) for spec in specs if getattr(spec, field)]
        double = next((value for value in values if values.count(value) > 1), None)
        if double is not None:
            raise FleetError(f'{path}: two robots have the {field} {double}')
    return specs


def _spec(path: str, number: int, row: object) -> RobotSpec:
    where = f'{path}: robot {number}'
    if not isinstance(row, dict):
        raise FleetError(f'{where}: expected a mapping with name and port')
    unknown = set(row) - {'name', 'port', 'outgoing', 'start', 'battery'}
    if unknown:
        raise FleetError(f'{where}: unknown field {sorted(map(str, unknown))[0]}')
    try:
        port = int(row['port'])
        if not 0 <= port < 65536:
            raise ValueError(f'port {port} is out of range')
        start = row.get('start')
        if start is not None:
            start = start_pose(*start)
        outgoing = address(row['outgoing']) if row.get('outgoing') else None
        return RobotSpec(str(row.get('name', f'robot{number}')), port, outgoing, start,
                         percent(row.get('battery', 100.0)))
    except KeyError:
        raise FleetError(f'{where}: has no port') from None
    except (TypeError, ValueError) as error:
        raise FleetError(f'{where}: {error}') from error
