"""Fleet files for several tests."""
from __future__ import annotations

from pathlib import Path
from typing import List

from fleet_bringup.options import Options
from fleet_bringup.robot_entries import RobotEntry, read_entries
from fleet_core.files.fleet_file import load_fleet

HEAD = '''clearance: 0.1
robot_types:
- {name: ld90, radius: 0.43, speed: 1.35, play: 0.25, docks: [16]}
- {name: agv, radius: 0.35, speed: 1.0}
robots:
'''


def fleet_file(folder: Path, *robots: str) -> str:
    """Writes a fleet file with these robots, one per line from line 6 on. Returns its path."""
    path = folder / 'fleet.yaml'
    path.write_text(HEAD + ''.join(f'- {{{robot}}}\n' for robot in robots))
    return str(path)


def entries(folder: Path, *robots: str, **options: object) -> List[RobotEntry]:
    """Returns the entries of these robots."""
    path = fleet_file(folder, *robots)
    return read_entries(path, load_fleet(path), Options(fleet=path, **options))
