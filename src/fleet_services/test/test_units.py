"""Units contain everything that systemd needs, start in the right order, and have few permissions.
"""
from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from typing import Dict, List

import pytest

from fleet_services.units import Service, System, unit_files

PAUSE = Path(__file__).resolve().parents[1] / 'config' / 'restart_pause'
SERVICES = (
    Service('master', 'ROS master', '/usr/bin/env a', is_watched=False),
    Service('robots-1', 'Robots', '/usr/bin/env b', ('ld90_1.password',)),
    Service('page', 'Web page', '/usr/bin/env c', ('token_file',), reads=('robots-1',),
            peers=('10.0.0.0/24',)))


def system(version: int = 252) -> System:
    return System('hall', 'fleet', '/etc/fleet/hall', str(PAUSE), version)


def settings(text: str, key: str) -> List[str]:
    return re.findall(f'^{key}=(.*)$', text, re.MULTILINE)


@pytest.fixture(scope='module')
def units() -> Dict[str, str]:
    return unit_files(SERVICES, system())


def test_the_target_wants_all_services(units):
    assert set(units) == {'fleet-hall.target', 'fleet-hall-master.service',
                          'fleet-hall-robots-1.service', 'fleet-hall-page.service'}
    assert set(settings(units['fleet-hall.target'], 'Wants')[0].split()) == (
        set(units) - {'fleet-hall.target'})


def test_a_service_starts_after_those_before_it(units):
    assert settings(units['fleet-hall-page.service'], 'After') == [
        'network-online.target fleet-hall-master.service fleet-hall-robots-1.service']


def test_a_watched_service_is_restarted_when_it_gives_no_sign_of_life(units):
    assert settings(units['fleet-hall-page.service'], 'WatchdogSec') == ['30']
    assert settings(units['fleet-hall-page.service'], 'Type') == ['notify']
    assert settings(units['fleet-hall-master.service'], 'WatchdogSec') == []


def test_systemd_hands_a_secret_to_the_one_service_that_needs_it(units):
    assert settings(units['fleet-hall-robots-1.service'], 'LoadCredential') == [
        'ld90_1.password:/etc/fleet/hall/secrets/ld90_1.password']
    assert system().secret('page', 'token_file') == (
        '/run/credentials/fleet-hall-page.service/token_file')


def test_an_older_systemd_lets_the_user_read_the_kept_secret():
    old = system(245)
    assert settings(unit_files(SERVICES, old)['fleet-hall-page.service'], 'LoadCredential') == []
    assert old.secret('page', 'token_file') == '/etc/fleet/hall/secrets/token_file'


def test_a_unit_sees_its_own_state_only(units):
    unit = units['fleet-hall-page.service']
    assert settings(unit, 'TemporaryFileSystem') == ['%S/fleet:ro %L/fleet:ro']
    assert settings(unit, 'StateDirectory') == ['fleet/hall/page']
    assert settings(unit, 'BindPaths') == ['%S/fleet/hall/page %L/fleet/hall/page']
    assert settings(unit, 'BindReadOnlyPaths') == ['-%S/fleet/hall/robots-1']
    assert settings(units['fleet-hall-robots-1.service'], 'BindReadOnlyPaths') == []
    assert 'HOME=%S/fleet/hall/page' in settings(unit, 'Environment')[0].split()


def test_a_unit_communicates_only_with_what_it_needs(units):
    assert settings(units['fleet-hall-page.service'], 'IPAddressDeny') == ['any']
    assert settings(units['fleet-hall-page.service'], 'IPAddressAllow') == [
        'localhost 10.0.0.0/24']
    assert settings(units['fleet-hall-master.service'], 'IPAddressDeny') == []


def test_pauses_between_restarts_grow():
    assert settings(unit_files(SERVICES, system(254))['fleet-hall-page.service'],
                    'RestartSteps') == ['5']
    older = unit_files(SERVICES, system(252))['fleet-hall-page.service']
    assert settings(older, 'RestartSteps') == []
    assert settings(older, 'ExecStopPost') == [str(PAUSE)]


def test_the_pause_doubles_with_each_failure_in_a_row(tmp_path):
    bin = tmp_path / 'bin'
    bin.mkdir()
    (bin / 'sleep').write_text('#!/bin/sh\necho "$1"\n')
    (bin / 'sleep').chmod(0o755)

    def pause(result: str) -> str:
        return subprocess.run([str(PAUSE)], check=True, text=True, stdout=subprocess.PIPE, env={
            'PATH': f'{bin}:/usr/bin:/bin', 'RUNTIME_DIRECTORY': str(tmp_path),
            'SERVICE_RESULT': result}).stdout.strip()
    assert [pause('exit-code') for _ in range(8)] == ['2', '4', '8', '16', '32', '64', '64', '64']
    assert pause('success') == ''
    assert pause('watchdog') == '2'


@pytest.mark.skipif(shutil.which('systemd-analyze') is None, reason='systemd is not installed')
@pytest.mark.parametrize('version', [245, 252])
def test_systemd_finds_nothing_wrong_and_little_exposed(tmp_path, version):
    for name, text in unit_files(SERVICES, system(version)).items():
        (tmp_path / name).write_text(text)
    files = sorted(map(str, tmp_path.iterdir()))
    verified = subprocess.run(['systemd-analyze', 'verify', *files], check=False, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert (verified.returncode, verified.stdout) == (0, '')
    for file in files:
        if file.endswith('.service'):
            judged = subprocess.run(
                ['systemd-analyze', 'security', '--offline=true', '--threshold=20', file],
                check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            assert judged.returncode == 0, judged.stdout
