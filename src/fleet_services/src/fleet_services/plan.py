"""Plans the services of a site: their launch files, and the secrets that each may read.

Each secret of the site (ARCL passwords, the page's tokens and key) is read only by the service that
needs it, from the path at which systemd provides it.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Dict, List, Mapping, Sequence, Tuple

from fleet_bringup.files import Site
from fleet_bringup.launch_file import Part, launch_text, parts_of
from fleet_bringup.options import Options
from fleet_bringup.robot_entries import LD90, Entry
from fleet_services.site_file import SiteFile
from fleet_services.units import Service, System

MASTER = 'master'
_DESCRIPTIONS = {Part.SIMULATORS: 'Simulated robots', Part.ROBOTS: 'Robots',
                 Part.MANAGER: 'Fleet manager', Part.PAGE: 'Web page'}
#: Options of the page that name secret files.
_OF_THE_PAGE = ('token_file', 'key_file')


@dataclass(frozen=True)
class Plan:
    """The files to install.

    launches -- texts of launch files, by the names of their services
    secrets  -- the source file of each secret, by the secret's name
    """

    services: Tuple[Service, ...]
    launches: Dict[str, str]
    secrets: Dict[str, str]


def plan_services(site: SiteFile, entries: Sequence[Entry], graph: Site, files: Dict[str, str],
                  system: System, programs: Mapping[str, str]) -> Plan:
    """All services of a site, in the order in which they start.

    files    -- paths by the kind of file
    programs -- absolute paths of `roscore` and `roslaunch`
    """
    services = [Service(MASTER, 'ROS master', f'{programs["roscore"]} -p {site.master_port}',
                        is_watched=False)]
    launches: Dict[str, str] = {}
    secrets: Dict[str, str] = {}

    def add(name: str, part: Part, own: Sequence[Entry], options: Options,
            needed: Mapping[str, str]) -> None:
        launches[name] = launch_text(own, graph, options, files, (part,))
        secrets.update(needed)
        services.append(Service(
            name, _DESCRIPTIONS[part],
            f'{programs["roslaunch"]} --wait --skip-log-check {system.settings}/{name}.launch',
            tuple(sorted(needed))))

    for part in parts_of(entries, site.options):
        if part is Part.ROBOTS:
            for name, group in _groups(entries, site.robots_per_unit):
                passwords = {f'{one.name}.password': one.password_file for one in group
                             if one.password_file}
                own = [replace(one, password_file=system.secret(name, f'{one.name}.password'))
                       if one.password_file else one for one in group]
                add(name, part, own, site.options, passwords)
        elif part is Part.PAGE:
            needed = {key: getattr(site.options, key) for key in _OF_THE_PAGE
                      if getattr(site.options, key)}
            paths = {key: system.secret(part.value, key) if key in needed else ''
                     for key in _OF_THE_PAGE}
            add(part.value, part, entries, replace(
                site.options, token_file=paths['token_file'], key_file=paths['key_file']), needed)
        else:
            add(part.value, part, entries, site.options, {})
    return Plan(tuple(services), launches, secrets)


def _groups(entries: Sequence[Entry], size: int) -> List[Tuple[str, List[Entry]]]:
    """Groups of at most `size` LD-90s that share a unit, with the names of their services."""
    ld90s = [entry for entry in entries if entry.robot.driver == LD90]
    return [(f'robots-{number + 1}', ld90s[begin:begin + size])
            for number, begin in enumerate(range(0, len(ld90s), size))]
