"""Installs the services of a site on a machine, and removes them. Only this module needs root."""
from __future__ import annotations

import os
import pwd
import re
import shutil
import stat
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Dict, Iterable, List, Mapping, Tuple

from roslaunch.config import ROSLaunchConfig
from roslaunch.core import RLException
from roslaunch.node_args import get_node_list
from roslaunch.xmlloader import XmlLoader
from roslib.packages import find_node

from fleet_bringup.command import gather
from fleet_services.ownership import NotDone, as_user, owner_of
from fleet_services.plan import InstallationPlan, plan_services
from fleet_services.site_file import SiteFile
from fleet_services.state_folders import DATA, LOGS, make_private, move, planned_moves
from fleet_services.units import System, unit_files

#: Environment variables of this process that the nodes need as well.
_INHERITED = re.compile(r'ROS_(?!MASTER_URI|IP|HOSTNAME|HOME|LOG_DIR|NAMESPACE)\w+|PYTHONPATH|PATH|'
                        r'LD_LIBRARY_PATH|CMAKE_PREFIX_PATH')
#: Names of nodes that have no watchdog of this project.
NOT_WATCHED = re.compile(r'/(?:\w+/)*(?:node_host|ld90_sim|master_discovery|master_sync)\w*\Z')
#: Environment variables that are lists of folders. An empty entry would be the working directory.
_LISTS = re.compile(r'ROS_PACKAGE_PATH|PYTHONPATH|PATH|LD_LIBRARY_PATH|CMAKE_PREFIX_PATH')
UNITS = 'etc/systemd/system'
SETTINGS = 'etc/fleet'
READABLE, RUNNABLE = 0o640, 0o750  # modes of files that the services' group reads, or runs
PUBLIC, SECRET, CLOSED = 0o644, 0o600, 0o700


class NotInstalled(Exception):
    """The services cannot be installed. The text is a sentence that says what to do."""


@dataclass(frozen=True)
class Machine:
    """The machine on which services are installed.

    root    -- folder of its files; `/`: this machine
    systemd -- version of systemd
    """

    root: Path
    systemd: int

    @property
    def is_this(self) -> bool:
        """Whether this is the machine that runs this program, and not an image of another machine.
        """
        return self.root == Path('/')

    @property
    def runs_systemd(self) -> bool:
        """Whether services can be started now."""
        return self.is_this and Path('/run/systemd/system').is_dir()

    def ids(self, user: str) -> Tuple[int, int]:
        """Returns the numbers of a user and of the group with the same name.

        A number is -1 if the machine does not have the name, or if this process is not root.
        `chown` with -1 changes nothing.
        """
        if os.geteuid() != 0:
            return -1, -1
        return self._id('etc/passwd', user), self._id('etc/group', user)

    def _id(self, file: str, name: str) -> int:
        try:
            text = self.path(file).read_text(encoding='utf-8')
        except FileNotFoundError:
            return -1
        found = re.search(rf'^{re.escape(name)}:[^:]*:(\d+):', text, re.MULTILINE)
        return int(found[1]) if found else -1

    def path(self, *parts: str) -> Path:
        """Returns a path below the root."""
        return self.root.joinpath(*parts)


def systemd_version() -> int:
    """Returns the version of systemd on this machine; 0: there is none."""
    try:
        said = subprocess.run(['systemctl', '--version'], check=True, text=True,
                              stdout=subprocess.PIPE).stdout
    except (OSError, subprocess.CalledProcessError):
        return 0
    found = re.match(r'systemd (\d+)', said)
    return int(found[1]) if found else 0


def install(site: SiteFile, package: Path, machine: Machine) -> List[str]:
    """Writes all files, and starts the services if systemd runs. Returns lines about the result.

    package -- folder of this ROS package
    Raises NotInstalled, CannotStart, FileError, OSError.
    """
    settings = machine.path(SETTINGS, site.name)
    system = System(site.name, site.user, f'/{SETTINGS}/{site.name}',
                    f'/{SETTINGS}/{site.name}/restart_pause', machine.systemd)
    if machine.is_this:
        _make_user(site.user, machine.path(DATA, site.name))
        _check_reads(site.user, package)
        refuse_replaceable((package, *map(Path, site.sources)), pwd.getpwnam(site.user).pw_uid)
    settings.parent.mkdir(parents=True, exist_ok=True, mode=0o755)
    made = Path(tempfile.mkdtemp(prefix='.', dir=settings.parent))
    try:
        plan = _make_settings(site, system, machine, package, made)
        said = _divide_state(site, plan, system, machine)
        shutil.rmtree(settings, ignore_errors=True)
        made.rename(settings)
    except NotDone as error:
        raise NotInstalled(str(error)) from None
    finally:
        shutil.rmtree(made, ignore_errors=True)
    units = unit_files(plan.services, system)
    left = [unit for unit in _units_of(machine.path(UNITS, system.target))
            if unit.name not in units]
    if machine.runs_systemd and left:
        _run('systemctl', 'stop', *(unit.name for unit in left))
    for unit in left:
        unit.unlink()
    for name, text in units.items():
        _write(machine.path(UNITS, name), text, PUBLIC)
    said.append(f'{len(units)} units in {machine.path(UNITS)}, their files in {settings}.')
    if os.geteuid() == 0 and machine.ids(site.user)[1] < 0:
        said.append(f'{machine.root} has no group {site.user}, so the services could not read '
                    'their files: add this user there, then run this command again.')
    if machine.runs_systemd:
        _run('systemctl', 'daemon-reload')
        _run('systemctl', 'enable', system.target)
        _run('systemctl', 'restart', '--no-block', system.target)
        said.append(f'Started: systemctl status "fleet-{site.name}-*"')
    else:
        said.append('systemd does not run on this machine, so nothing was started.')
    return said


def remove(name: str, machine: Machine, purge: bool) -> List[str]:
    """Removes a site's services, and with `purge` its data. Returns lines about the result."""
    target = machine.path(UNITS, f'fleet-{name}.target')
    units = _units_of(target)
    settings = machine.path(SETTINGS, name)
    data = [machine.path(DATA, name), machine.path(LOGS, name)]
    if not (target.exists() or settings.exists() or purge and any(map(Path.exists, data))):
        raise NotInstalled(f'There is no site {name} below {machine.root}.')
    if machine.runs_systemd and target.exists():
        _run('systemctl', 'disable', '--now', *(unit.name for unit in units))
    for unit in units:
        unit.unlink()
    shutil.rmtree(settings, ignore_errors=True)
    said = [f'The services of {name} are removed.']
    if purge:
        for folder in data:
            shutil.rmtree(folder, ignore_errors=True)
        said.append('Its journal, records and logs are removed, too.')
    else:
        said.append(f'Its data stay in {data[0]} and {data[1]}; --purge removes them.')
    if machine.runs_systemd:
        _run('systemctl', 'daemon-reload')
    return said


def _units_of(target: Path) -> List[Path]:
    """Returns the existing unit files: of the target, and of the services that the target names."""
    if not target.exists():
        return []
    names = re.findall(r'fleet-[a-z0-9-]+\.service', target.read_text(encoding='utf-8'))
    return [unit for unit in (target, *map(target.with_name, names)) if unit.exists()]


def _make_settings(site: SiteFile, system: System, machine: Machine, package: Path,
                   folder: Path) -> InstallationPlan:
    """Makes all files that the units need, in a new folder. A running site keeps its old folder."""
    plan = _make_files(site, system, folder)
    shutil.copyfile(package / 'config' / 'restart_pause', folder / 'restart_pause')
    _write(folder / 'environment', _environment(site, os.environ))
    user, group = machine.ids(site.user)
    if machine.is_this:
        refuse_replaceable(map(Path, plan.secrets.values()), user)
    for path in (*folder.iterdir(), folder):
        path.chmod(RUNNABLE if path.is_dir() or path.name == 'restart_pause' else READABLE)
        os.chown(path, -1, group)
    for name, source in plan.secrets.items():
        _keep_secret(Path(source), folder / 'secrets' / name)
        if not system.has_credentials:  # the services themselves read the secrets
            (folder / 'secrets').chmod(RUNNABLE)
            os.chown(folder / 'secrets', -1, group)
            os.chown(folder / 'secrets' / name, user, group)
    return plan


def _divide_state(site: SiteFile, plan: InstallationPlan, system: System,
                  machine: Machine) -> List[str]:
    """Moves the state of a site of 1.0.0, and the state of a robot whose unit has changed.

    Only the owner of the state touches it. State that belongs to no unit stays where it is.
    """
    home = machine.path(DATA, site.name)
    user, group = machine.ids(site.user)
    moves = planned_moves(home, plan.state, plan.robots)
    owner = owner_of(home)
    running = _units_of(machine.path(UNITS, system.target))
    if moves and running and machine.runs_systemd:
        _run('systemctl', 'stop', *(unit.name for unit in running))
    if owner:  # the folder of a site of 1.0.0, or of a site that never ran
        as_user(owner, lambda: move(moves), group)
    _own(home, -1 if os.geteuid() else 0, group, RUNNABLE)
    for name in (service.name for service in plan.services):
        _own(home / name, user, group, CLOSED)
    if not owner:
        as_user(max(user, 0), lambda: move(moves), group)
    logs = machine.path(LOGS, site.name)
    _close([*(home / service.name for service in plan.services),
            *(logs.iterdir() if logs.is_dir() else ())], group)
    return [f'Moved {source} to {target}.' for source, target in moves]


def _close(folders: Iterable[Path], group: int) -> None:
    """Makes the files in each of these folders private, with the rights of the folder's owner."""
    for folder in folders:
        if folder.is_dir() and not folder.is_symlink():
            as_user(owner_of(folder), partial(make_private, folder), group)


def _own(folder: Path, user: int, group: int, mode: int) -> None:
    """Makes a folder if it is missing, and gives it this owner and mode. Follows no link."""
    folder.mkdir(parents=True, exist_ok=True)
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        os.fchown(opened, user, group)
        os.fchmod(opened, mode)
    finally:
        os.close(opened)


def _make_files(site: SiteFile, system: System, settings: Path) -> InstallationPlan:
    """Makes graph, map, fleet file and launch files. Paths in these files do not contain the root.
    """
    gathered = gather(site.options, str(settings), check=False)
    files, graph = dict(gathered.files), gathered.site
    for path in (files['fleet'], graph.map_file):
        if path and Path(path).parent != settings:
            shutil.copyfile(path, settings / Path(path).name)
    moved = {what: _installed(path, settings, system) for what, path in files.items()}
    graph = type(graph)(graph.graph, _installed(graph.graph_file, settings, system),
                        graph.map_file and _installed(graph.map_file, settings, system))
    plan = plan_services(site, gathered.entries, graph, moved, system, {
        name: _program(name) for name in ('roscore', 'roslaunch')})
    for name, text in plan.launches.items():
        launch = settings / f'{name}.launch'
        _write(launch, text)
        _write(launch, _watched(text, name, _nodes_of(launch)))
    return plan


def _installed(path: str, settings: Path, system: System) -> str:
    """Returns the path that a file has after the installation. Files of packages keep their paths.
    """
    name = Path(path).name
    return f'{system.settings}/{name}' if (settings / name).exists() else path


def _watched(text: str, name: str, nodes: List[str]) -> str:
    """Returns the launch file with one more node, which reports the state of `nodes` to systemd."""
    root = ET.fromstring(text)
    node = ET.SubElement(root, 'node', {
        'name': f'service_watch_{name.replace("-", "_")}', 'pkg': 'fleet_services',
        'type': 'service_watch', 'output': 'screen', 'respawn': 'true', 'respawn_delay': '1'})
    ET.SubElement(node, 'param', name='nodes', value=' '.join(nodes))
    return ET.tostring(root, encoding='unicode') + '\n'


def _nodes_of(launch: Path) -> List[str]:
    """Returns the nodes of a launch file that have a watchdog of this project.

    roslaunch's `load_config_default` is not used: it also reads the file of roscore, which starts
    two programs to find out versions. This would take most of the time and add no node of the site.
    """
    read = ROSLaunchConfig()
    try:
        XmlLoader().load(str(launch), read, verbose=False)
    except RLException as error:
        raise NotInstalled(f'{launch} cannot be read by roslaunch: {error}') from None
    return [name for name in get_node_list(read) if not NOT_WATCHED.match(name)]


def _program(name: str) -> str:
    path = shutil.which(name)
    if path is None:
        raise NotInstalled(f'{name} is not in PATH: source the setup file of the workspace first.')
    return path


def _folder_of_master() -> str:
    """Returns the folder of this workspace's ROS master, which refuses web browsers.

    roscore starts the first `rosmaster` in PATH.
    """
    found = find_node('node_lifecycle', 'rosmaster')
    if not found:
        raise NotInstalled('The package node_lifecycle has no program rosmaster: build the '
                           'workspace again.')
    return str(Path(found[0]).parent)


def _environment(site: SiteFile, environment: Mapping[str, str]) -> str:
    """Returns the EnvironmentFile of all units."""
    kept: Dict[str, str] = {name: value for name, value in sorted(environment.items())
                            if _INHERITED.fullmatch(name)}
    for name, value in kept.items():
        if _LISTS.fullmatch(name):
            kept[name] = ':'.join(one for one in value.split(':') if one.startswith('/'))
    kept['PATH'] = f'{_folder_of_master()}:{kept["PATH"]}'
    kept.update({'ROS_IP': site.address, 'LANG': 'C.UTF-8',
                 'ROS_MASTER_URI': f'http://{site.address}:{site.master_port}',
                 # With these, a unit imports only files that root has installed.
                 'PYTHONNOUSERSITE': '1', 'PYTHONSAFEPATH': '1', 'PYTHONDONTWRITEBYTECODE': '1'})
    return ''.join(f'{name}="{value}"\n' for name, value in kept.items())


def _write(path: Path, text: str, mode: int = READABLE) -> None:
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o755)
    path.write_text(text, encoding='utf-8')
    path.chmod(mode)


def _keep_secret(source: Path, kept: Path) -> None:
    """Makes a copy of a file. Only root can read the copy."""
    kept.parent.mkdir(mode=CLOSED, exist_ok=True)
    with open(os.open(kept, os.O_WRONLY | os.O_CREAT | os.O_EXCL, SECRET), 'wb') as stream:
        stream.write(source.read_bytes())


def _make_user(name: str, home: Path) -> None:
    try:
        uid = pwd.getpwnam(name).pw_uid
    except KeyError:
        _run('useradd', '--system', '--user-group', '--home-dir', str(home), '--no-create-home',
             '--shell', '/usr/sbin/nologin', name)
    else:
        if uid == 0:
            raise NotInstalled('The services need a user without privileges: choose another one.')


def _check_reads(user: str, package: Path) -> None:
    program = package / 'config' / 'restart_pause'
    done = subprocess.run(['runuser', '-u', user, '--', 'test', '-r', str(program)], check=False)
    if done.returncode:
        raise NotInstalled(f'The user {user} cannot read {program}: move the workspace to a folder '
                           'that all users can read, such as /opt/omron_ld90.')


def refuse_replaceable(paths: Iterable[Path], user: int) -> None:
    """Raises NotInstalled for a file that the services' user, or every user, can replace.

    This matters because root reads and runs these files.
    """
    for path in paths:
        for place in (path.absolute(), path.resolve()):
            for one in (place, *place.parents):
                status = one.lstat()
                is_open = status.st_mode & stat.S_IWOTH and not (
                    status.st_mode & stat.S_ISVTX or stat.S_ISLNK(status.st_mode))
                if status.st_uid == user or is_open:
                    raise NotInstalled(
                        f'The user of the services can replace {path}, because {one} belongs to '
                        'that user, or all users may write there: move it to a folder of yours.')


def _run(*command: str) -> None:
    done = subprocess.run(command, check=False, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    if done.returncode:
        raise NotInstalled(f'{" ".join(command)} failed: {done.stdout.strip()}')
