"""The texts of systemd units; see systemd.exec(5) and systemd.service(5).

Nothing here looks at the machine: `System` says what it has.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Sequence, Tuple

CREDENTIALS_FROM = 247    # version of systemd that knows LoadCredential
RESTART_STEPS_FROM = 254  # and RestartSteps
WATCHDOG = 30  # s without a sign of life, after which systemd restarts a unit
START = 180    # s that a unit may take until all its nodes work
STOP = 90      # s; the pause before a restart is part of it
OPEN_FILES = 16384

#: What a unit may not do; `systemd-analyze security` looks at these. Without ProcSubset, as the
#: boot id in /proc/sys tells ages; without PrivateNetwork, as the nodes talk by TCP.
HARDENING = (
    'NoNewPrivileges=yes', 'CapabilityBoundingSet=', 'AmbientCapabilities=',
    'ProtectSystem=strict', 'ProtectHome=read-only', 'PrivateTmp=yes', 'PrivateDevices=yes',
    'DevicePolicy=closed', 'PrivateUsers=yes', 'ProtectHostname=yes', 'ProtectClock=yes',
    'ProtectKernelTunables=yes', 'ProtectKernelModules=yes', 'ProtectKernelLogs=yes',
    'ProtectControlGroups=yes', 'ProtectProc=invisible', 'RestrictNamespaces=yes',
    'RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK', 'RestrictRealtime=yes',
    'RestrictSUIDSGID=yes', 'LockPersonality=yes', 'MemoryDenyWriteExecute=yes',
    'RemoveIPC=yes', 'KeyringMode=private', 'UMask=0077', 'SystemCallArchitectures=native',
    'SystemCallFilter=@system-service', 'SystemCallFilter=~@privileged @resources',
    'SystemCallErrorNumber=EPERM')


@dataclass(frozen=True)
class System:
    """What the units are for. Folders and programs by absolute paths.

    settings -- folder of the launch files and the environment, which only root writes
    pause -- the program that waits before a restart
    """

    site: str
    user: str
    settings: str
    pause: str
    version: int  # of systemd

    @property
    def has_credentials(self) -> bool:
        """Whether systemd itself hands secrets to units."""
        return self.version >= CREDENTIALS_FROM

    @property
    def target(self) -> str:
        """Name of the unit that stands for all."""
        return f'fleet-{self.site}.target'

    def unit(self, name: str) -> str:
        """Name of a service."""
        return f'fleet-{self.site}-{name}.service'

    def secret(self, name: str, secret: str) -> str:
        """Path under which the service `name` reads a secret."""
        if self.has_credentials:
            return f'/run/credentials/{self.unit(name)}/{secret}'
        return self.kept_secret(secret)

    def kept_secret(self, secret: str) -> str:
        """Path at which a secret is kept."""
        return f'{self.settings}/secrets/{secret}'


@dataclass(frozen=True)
class Service:
    """One unit.

    command -- ExecStart
    secrets -- names of the secrets that it may read
    is_watched -- it tells systemd when it is ready, and that it works
    """

    name: str
    description: str
    command: str
    secrets: Tuple[str, ...] = ()
    is_watched: bool = True


def unit_files(services: Sequence[Service], system: System) -> Dict[str, str]:
    """The texts of all units, by their names; services start in this order."""
    names = [system.unit(one.name) for one in services]
    units = {name: _service(one, names[:number], system)
             for number, (name, one) in enumerate(zip(names, services))}
    units[system.target] = '\n'.join((
        '[Unit]', f'Description=Fleet of the site {system.site}',
        f'Wants={" ".join(sorted(units))}', '', '[Install]', 'WantedBy=multi-user.target', ''))
    return units


def _service(service: Service, before: Sequence[str], system: System) -> str:
    lines: List[str] = [
        '[Unit]', f'Description={service.description} of the site {system.site}',
        f'PartOf={system.target}', 'Wants=network-online.target',
        f'After={" ".join(("network-online.target", *before))}',
        'StartLimitIntervalSec=0',  # it is tried for ever, with growing pauses
        '', '[Service]', f'User={system.user}', f'Group={system.user}',
        f'EnvironmentFile={system.settings}/environment',
        f'Environment=ROS_LOG_DIR=%L/fleet/{system.site}/{service.name}',
        f'StateDirectory=fleet/{system.site}', f'LogsDirectory=fleet/{system.site}/{service.name}',
        f'RuntimeDirectory=fleet-{system.site}-{service.name}', 'RuntimeDirectoryPreserve=yes',
        f'WorkingDirectory=%S/fleet/{system.site}', f'ExecStart={service.command}',
        'KillMode=mixed', 'KillSignal=SIGINT', f'TimeoutStopSec={STOP}',
        f'LimitNOFILE={OPEN_FILES}', 'LimitCORE=0', 'Restart=always']
    if system.version >= RESTART_STEPS_FROM:
        lines += ['RestartSec=2', 'RestartSteps=5', 'RestartMaxDelaySec=64']
    else:
        lines += ['RestartSec=1', f'ExecStopPost={system.pause}']
    if service.is_watched:
        lines += ['Type=notify', 'NotifyAccess=all', f'TimeoutStartSec={START}',
                  f'WatchdogSec={WATCHDOG}', 'WatchdogSignal=SIGINT']
    else:
        lines += ['Type=exec']
    if system.has_credentials:
        lines += [f'LoadCredential={secret}:{system.kept_secret(secret)}'
                  for secret in service.secrets]
    return '\n'.join((*lines, *HARDENING, ''))
