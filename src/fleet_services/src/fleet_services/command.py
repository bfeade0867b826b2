"""`scripts/install_service.sh`: runs a site as systemd services of this computer.

    install_service.sh site.yaml       makes the units and starts them; run it again after each change of the site's files
    install_service.sh --remove NAME   stops and removes the services; keeps the site's data
    install_service.sh --purge NAME    removes also the journal, records and logs
    install_service.sh --root DIR ...  does the same below DIR, for an image; starts nothing

docs/how-to/services.md describes the site file. Needs root. Exit status 0: done; 1: not done, with one sentence.
"""  # noqa: E501 - it is shown by --help
from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import List, Optional, Sequence

import rospkg

from fleet_bringup.errors import CannotStart
from fleet_core.files.errors import FileError
from fleet_services.installation import Machine, NotInstalled, install, remove, systemd_version
from fleet_services.site_file import read_site, site_name
from trajectory_graph import GraphError
from trajectory_graph.strict_yaml import WrongYaml


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or '-h' in words or '--help' in words:
        print(__doc__)
        return 0 if words else 1
    try:
        print('\n'.join(_do(words)))
    except (NotInstalled, CannotStart, FileError, GraphError, WrongYaml) as error:
        print(error, file=sys.stderr)
        return 1
    except OSError as error:
        print(f'The installation failed: {error}.', file=sys.stderr)
        return 1
    return 0


def _do(words: List[str]) -> List[str]:
    root = Path('/')
    if words[0] == '--root' and len(words) > 1:
        root, words = Path(words[1]).resolve(), words[2:]
    elif os.geteuid() != 0:
        raise NotInstalled('To install services, root is needed: run the command with sudo.')
    os.umask(0o022)  # folders of the system; all other modes are given explicitly
    machine = Machine(root, systemd_version())
    if machine.is_this and not machine.systemd:
        raise NotInstalled('This computer has no systemd: to make the files for another computer, '
                           'give --root DIR.')
    if len(words) == 2 and words[0] in ('--remove', '--purge'):
        return remove(site_name(words[1]), machine, purge=words[0] == '--purge')
    if len(words) != 1 or words[0].startswith('-'):
        raise NotInstalled('Wrong arguments: give the path of the site file, --remove NAME, or '
                           '--purge NAME.')
    package = Path(rospkg.RosPack().get_path('fleet_services'))
    return install(read_site(words[0]), package, machine)
