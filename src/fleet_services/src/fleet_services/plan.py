"""Plans the services of a site: their launch files, and the secrets that each service may read.

A secret of the site (ARCL password, the page's tokens or key) is read only by the service that
needs it, from the path at which systemd provides it. Each service keeps its state in its own
folder. If the site file lists the networks, a service communicates only with the addresses that it
needs.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from ipaddress import ip_address
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

from fleet_bringup.files import StartedSite
from fleet_bringup.launch_file import Part, launch_text, parts_of
from fleet_bringup.options import Options
from fleet_bringup.robot_entries import LD90, RobotEntry
from fleet_services.site_file import SiteFile
from fleet_services.state_folders import DATA, MANAGER, MASTER, UNITS
from fleet_services.units import Service, System

JOURNAL = 'graph_fleet_manager/fleet.sqlite'
_DESCRIPTIONS = {Part.SIMULATORS: 'Simulated robots', Part.ROBOTS: 'Robots',
                 Part.MANAGER: 'Fleet manager', Part.PAGE: 'Web page'}
#: Options of the page that name secret files.
_OF_THE_PAGE = ('token_file', 'key_file')


@dataclass(frozen=True)
class InstallationPlan:
    """The files to install.

    launches -- text of each service's launch file; the keys are the names of the services
    secrets  -- source file of each secret; the keys are the names of the secrets
    robots   -- service of each robot whose nodes run here; the keys are the names of the robots
    """

    services: Tuple[Service, ...]
    launches: Dict[str, str]
    secrets: Dict[str, str]
    robots: Dict[str, str]

    @property
    def state(self) -> Dict[str, str]:
        """The name of the service for each folder of ROS_HOME that only one service needs."""
        names = {service.name for service in self.services}
        return {folder: name for folder, name in UNITS.items() if name in names}


def plan_services(site: SiteFile, entries: Sequence[RobotEntry], graph: StartedSite,
                  files: Dict[str, str], system: System,
                  programs: Mapping[str, str]) -> InstallationPlan:
    """Returns all services of a site, in the order in which they start.

    files    -- paths of the site's files; the keys are the kinds of file
    programs -- absolute paths of `roscore` and `roslaunch`
    """
    files = {**files, 'journal': f'/{DATA}/{site.name}/{MANAGER}/{JOURNAL}'}
    known = _networks(site, entries)
    options = site.options
    services = [Service(MASTER, 'ROS master', f'{programs["roscore"]} -p {site.master_port}',
                        is_watched=False, peers=known)]
    launches: Dict[str, str] = {}
    secrets: Dict[str, str] = {}
    robots: Dict[str, str] = {}

    def add(name: str, part: Part, own: Sequence[RobotEntry], options: Options,
            needed: Mapping[str, str], peers: Optional[Tuple[str, ...]] = known) -> None:
        launches[name] = launch_text(own, graph, options, files, (part,))
        secrets.update(needed)
        services.append(Service(
            name, _DESCRIPTIONS[part],
            f'{programs["roslaunch"]} --wait --skip-log-check {system.settings}/{name}.launch',
            tuple(sorted(needed)), reads=(MANAGER,) if part is Part.PAGE else (), peers=peers))

    for part in parts_of(entries, options):
        if part is Part.ROBOTS:
            for name, group in _groups(entries, site.robots_per_unit):
                robots.update((one.name, name) for one in group)
                own, passwords = _with_secret_passwords(group, name, system)
                add(name, part, own, options, passwords, _with(
                    known, [one.host for one in group if one.host]))
        elif part is Part.PAGE:
            needed = {key: getattr(options, key) for key in _OF_THE_PAGE if getattr(options, key)}
            paths: Dict[str, Any] = {key: system.secret(part.value, key) for key in needed}
            is_known = site.networks or _is_loopback(options.listen)
            add(part.value, part, entries, replace(options, **paths), needed,
                known if is_known else None)
        else:
            add(part.value, part, entries, options, {})
    return InstallationPlan(tuple(services), launches, secrets, robots)


def _with_secret_passwords(
        group: Sequence[RobotEntry], service: str,
        system: System) -> Tuple[List[RobotEntry], Dict[str, str]]:
    """Returns the robots, and the password files; the keys are the names of the secrets.

    The robots get the paths from which the service reads their passwords.
    """
    own, secrets = [], {}
    for one in group:
        if one.password_file:
            secret = f'{one.name}.password'
            secrets[secret] = one.password_file
            one = replace(one, password_file=system.secret(service, secret))
        own.append(one)
    return own, secrets


def _networks(site: SiteFile, entries: Sequence[RobotEntry]) -> Optional[Tuple[str, ...]]:
    """Returns the addresses with which every service may communicate; None: with all addresses,
    because the site file lists no networks.
    """
    if site.networks:
        return _with(tuple(site.networks), [site.address])
    is_alone = _is_loopback(site.address) and not any(entry.computer for entry in entries)
    return () if is_alone else None


def _with(known: Optional[Tuple[str, ...]], hosts: Sequence[str]) -> Optional[Tuple[str, ...]]:
    """Returns `known` and the addresses of `hosts`; None if a host has a name, because only DNS
    knows its address.
    """
    if known is None:
        return None
    try:
        return (*known, *(str(ip_address(host)) for host in hosts if not _is_loopback(host)))
    except ValueError:
        return None


def _is_loopback(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def _groups(entries: Sequence[RobotEntry], size: int) -> List[Tuple[str, List[RobotEntry]]]:
    """Returns groups of at most `size` LD-90s that share a unit, with the names of the services."""
    ld90s = [entry for entry in entries if entry.robot.driver == LD90]
    return [(f'robots-{number + 1}', ld90s[begin:begin + size])
            for number, begin in enumerate(range(0, len(ld90s), size))]
