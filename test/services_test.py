#!/usr/bin/env python3
"""The services of a site form a working fleet. They are started in their order, without systemd.

The test plays systemd: it starts each ExecStart in the environment of its unit, waits until the
unit reports that it is ready, and receives its watchdog messages.
"""
from __future__ import annotations

import os
import re
import shlex
import signal
import socket
import subprocess
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Dict, List, Tuple

from file_modes import differences, walk
from fleet_support import free_fleet_ports

from fleet_services.units import START
from ports import free_port
from system_support import run_cases, wait_until

ROOT = Path(__file__).resolve().parents[1]
SECONDS = 20.0  # s within which a unit must end
SIGNS = 2 * 15.0  # s within which a watchdog message must come


class Unit:
    """One service, and the socket on which it sends messages to systemd."""

    def __init__(self, file: Path, folder: Path) -> None:
        self.name = file.stem
        self._root = folder / 'root'
        self._text = file.read_text()
        self._said = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._path = str(folder / f'{self.name}.notify')
        self._said.bind(self._path)
        self._log = (folder / f'{self.name}.log').open('w+')

    def setting(self, key: str) -> List[str]:
        """Returns the values of a key."""
        return re.findall(f'^{key}=(.*)$', self._text, re.MULTILINE)

    @property
    def after(self) -> List[str]:
        """The units that start before this unit."""
        return [Path(name).stem for name in self.setting('After')[0].split()
                if name.endswith('.service')]

    def start(self) -> None:
        """Runs ExecStart. Returns when systemd would count the unit as started."""
        variables = Path(self.setting('EnvironmentFile')[0]).read_text().splitlines()
        environment: Dict[str, str] = {}
        for line in variables:
            name, _, value = shlex.split(line)[0].partition('=')
            environment[name] = value
        for word in self.setting('Environment')[0].split():
            name, _, value = word.partition('=')
            environment[name] = value.replace('%S', f'{self._root}/var/lib').replace(
                '%L', f'{self._root}/var/log')
        environment['NOTIFY_SOCKET'] = self._path
        for kind in ('State', 'Logs'):
            folder = {'State': 'lib', 'Logs': 'log'}[kind]
            (self._root / 'var' / folder / self.setting(f'{kind}Directory')[0]).mkdir(
                int(self.setting(f'{kind}DirectoryMode')[0], 8), parents=True, exist_ok=True)
        mask = int(self.setting('UMask')[0], 8)
        self._process = subprocess.Popen(
            ['sh', '-c', f'umask {mask:04o}; exec "$@"', '-',
             *shlex.split(self.setting('ExecStart')[0])],
            env=environment, cwd=environment['ROS_HOME'], stdout=self._log,
            stderr=subprocess.STDOUT, start_new_session=True)
        if self.setting('Type') == ['notify']:
            self.wait_for('READY=1', START)

    def wait_for(self, word: str, seconds: float) -> None:
        """Waits until the unit sends this word to systemd."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._said.settimeout(max(0.01, deadline - time.monotonic()))
            try:
                if self._said.recv(1000).decode() == word:
                    return
            except socket.timeout:
                break
        self._log.seek(0)
        raise AssertionError(f'{self.name} did not say {word} within {seconds:.0f} s:\n'
                             f'{self._log.read()[-3000:]}')

    def stop(self) -> int:
        """Ends the unit with its KillSignal."""
        self._process.send_signal(signal.Signals[self.setting('KillSignal')[0]])
        try:
            return self._process.wait(SECONDS)
        finally:
            if self._process.poll() is None:
                os.killpg(self._process.pid, signal.SIGKILL)
            self._said.close()
            self._log.close()


class Services(unittest.TestCase):

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.master, self.page = free_port(), free_port()

    def install(self) -> Tuple[Unit, ...]:
        """Installs a site below a folder, so that its files name this folder."""
        first = free_fleet_ports()
        site, root = self.folder / 'site.yaml', self.folder / 'root'
        site.write_text(
            f'name: hall\nmaster_port: {self.master}\narguments:\n  fleet: 1\n'
            f'  longest_edge: 1.5\n  page_port: {self.page}\n  arcl_port: {first}\n'
            f'  outgoing_port: {first + 5}\n  control_port: {first + 2}\n')
        subprocess.run(['rosrun', 'fleet_services', 'install_service', '--root', str(root),
                        str(site)], check=True)
        for file in root.rglob('*'):
            if file.is_file():
                text = file.read_text()
                for place in ('/etc/fleet', '/var/lib/fleet'):
                    text = text.replace(place, f'{root}{place}')
                file.write_text(text)
        units = [Unit(file, self.folder)
                 for file in (root / 'etc/systemd/system').glob('*.service')]
        return tuple(sorted(units, key=lambda unit: len(unit.after)))

    def test_the_services_come_up_in_their_order_and_serve_missions(self) -> None:
        units = self.install()
        self.assertEqual([unit.name.rpartition('hall-')[2] for unit in units],
                         ['master', 'simulators', 'robots-1', 'manager', 'page'])
        for unit in units:
            unit.start()
            self.addCleanup(unit.stop)

        wait_until(lambda: self.run_fleet('fleet', 'list').count('idle') == 2, 60.0, 'idle robots')
        self.assertIn('has succeeded', self.run_fleet('mission', '12', '--wait'))
        with urllib.request.urlopen(f'http://127.0.0.1:{self.page}/', timeout=10) as answer:
            self.assertEqual(answer.status, 200)
        for unit in units[1:]:
            unit.wait_for('WATCHDOG=1', SIGNS)
        state = self.folder / 'root/var/lib/fleet/hall'
        self.assertTrue((state / 'manager/graph_fleet_manager/fleet.sqlite').is_file())
        self.assertTrue((state / 'page/fleet_page/page.sqlite').is_file())
        names = {os.geteuid(): 'services', os.getegid(): 'services'}
        for folder in ('lib', 'log'):
            found = walk(self.folder / f'root/var/{folder}/fleet', f'/var/{folder}/fleet',
                         names)
            # the folders above belong to root, but this test does not always run as root
            self.assertEqual(differences(one for one in found if one[0].count('/') > 5), [])

    def run_fleet(self, *command: str) -> str:
        """Runs a command of the fleet manager at the ROS master of the services."""
        return subprocess.run(
            ['rosrun', 'graph_fleet_manager', *command], check=False, text=True, timeout=120,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            env={**os.environ, 'ROS_MASTER_URI': f'http://127.0.0.1:{self.master}'}).stdout


if __name__ == '__main__':
    run_cases(__file__)
