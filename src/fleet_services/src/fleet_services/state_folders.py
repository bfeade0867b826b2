"""The folders in which the units of a site keep their state: one for each unit.

    /var/lib/fleet/hall/manager/graph_fleet_manager/...
    /var/lib/fleet/hall/page/fleet_page/...
    /var/lib/fleet/hall/robots-1/omron_ld90/...

Up to version 1.0.0, all units shared the folder of the site, which was ROS_HOME of all nodes.
"""
from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import Iterator, List, Mapping, Tuple

from fleet_services.ownership import NotDone, owner_of, rename

DATA, LOGS = 'var/lib/fleet', 'var/log/fleet'
MASTER, MANAGER, PAGE = 'master', 'manager', 'page'
#: The unit to which each folder of ROS_HOME belongs.
UNITS: Mapping[str, str] = {'graph_fleet_manager': MANAGER, 'fleet_page': PAGE}
#: The folder of ROS_HOME with the files of single robots.
ROBOTS = 'omron_ld90'
_ENDINGS = ('_route.json', '_motion.json')
_LOCK = '.lock'
#: Files in which roscore stores its process id.
_PROCESS_IDS = 'roscore-*.pid'
_FOLDER, _FILE = 0o700, 0o600  # modes of the folders and files in the folder of a unit

Moves = List[Tuple[Path, Path]]


def state_folder(home: Path, folder: str) -> Path:
    """Returns the ROS_HOME that contains `folder`; `home` is ROS_HOME, or the folder of a site."""
    unit = home / UNITS[folder]
    is_site = home.absolute().parts[-4:-1] == tuple(DATA.split('/'))
    return unit if is_site and unit.is_dir() else home


def planned_moves(site: Path, units: Mapping[str, str], robots: Mapping[str, str]) -> Moves:
    """Returns the files and folders to move so that each unit finds its state in its own folder.

    site   -- the folder of the site
    units  -- the unit to which each folder of ROS_HOME belongs (`UNITS`), without missing units
    robots -- the unit of each robot, by the robot's name
    Raises NotDone if the state of a unit exists twice. See `move`.
    """
    moves = [(site / folder, site / unit / folder) for folder, unit in units.items()
             if (site / folder).is_dir()]
    moves += _moves_of_robots(site, robots)
    if owner_of(site):  # root does not own the folder, so the site is one of 1.0.0
        moves += [(file, site / MASTER / file.name) for file in sorted(site.glob(_PROCESS_IDS))]
    moves = [(source, target) for source, target in moves
             if not (source.name.endswith(_LOCK) and target.exists())]
    twice = next((move for move in moves if os.path.lexists(move[1])), None)
    if twice:
        raise NotDone(f'{twice[0]} and {twice[1]} are the state of the same unit: remove the older '
                      'one.')
    return moves


def _moves_of_robots(site: Path, robots: Mapping[str, str]) -> Iterator[Tuple[Path, Path]]:
    """Yields the files to move so that the files of each robot are in the folder of its unit."""
    names = {f'{robot}{ending}{lock}': unit for robot, unit in robots.items()
             for ending in _ENDINGS for lock in ('', _LOCK)}
    for home in [site, *sorted(site.glob('robots-*'))] if site.is_dir() else []:
        for file in _files(home / ROBOTS):
            unit = names.get(file.name, '')
            if unit and home != site / unit:
                yield file, site / unit / ROBOTS / file.name


def _files(folder: Path) -> Iterator[Path]:
    return iter(sorted(folder.iterdir())) if folder.is_dir() else iter(())


def move(moves: Moves) -> None:
    """Moves files and folders within a file system. A link itself is moved, not its target.

    A folder with files of robots is removed if it is empty afterwards.
    """
    for source, target in moves:
        target.parent.mkdir(parents=True, exist_ok=True, mode=_FOLDER)
        rename(source, target)
    for folder in {source.parent for source, _ in moves if source.parent.name == ROBOTS}:
        if not any(folder.iterdir()) and os.access(folder.parent, os.W_OK):
            folder.rmdir()


def make_private(folder: Path) -> None:
    """Sets the modes of a unit's folder, and of all its files that belong to this user, according
    to the table in docs/explanation/security.md. Files of version 1.0.0 have other modes. No link
    is followed.
    """
    folder.chmod(_FOLDER)
    for path, folders, files in os.walk(folder):
        for name in (*folders, *files):
            place = os.path.join(path, name)
            status = os.lstat(place)
            if status.st_uid != os.geteuid():
                continue
            if stat.S_ISDIR(status.st_mode):
                os.chmod(place, _FOLDER)
            elif stat.S_ISREG(status.st_mode):
                os.chmod(place, _FILE)
