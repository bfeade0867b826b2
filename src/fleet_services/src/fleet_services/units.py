"""The texts of systemd units; see systemd.exec(5) and systemd.service(5).

The functions here do not examine the machine: `System` describes it.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

CREDENTIALS_FROM = 247    # first version of systemd with LoadCredential
RESTART_STEPS_FROM = 254  # first version of systemd with RestartSteps
WATCHDOG = 30  # s; systemd restarts a unit that has not notified it for this time
START = 180    # s; within this time all nodes of a unit must begin to work
STOP = 90      # s; within this time a unit must end, including the pause before a restart
OPEN_FILES = 16384

#: Restrictions of each unit; `systemd-analyze security` rates them. ProcSubset is not set, because
#: the nodes need the boot id in /proc/sys to compute ages. PrivateNetwork is not set, because the
#: nodes communicate by TCP.
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
    """The site and the machine of the units. Folders and programs have absolute paths.

    settings -- folder of the launch files and of the environment; only root writes there
    pause    -- the program that waits before a restart
    version  -- version of systemd
    """

    site: str
    user: str
    settings: str
    pause: str
    version: int

    @property
    def has_credentials(self) -> bool:
        """Whether this systemd can pass secrets to units (LoadCredential)."""
        return self.version >= CREDENTIALS_FROM

    @property
    def target(self) -> str:
        """Name of the target that groups all units."""
        return f'fleet-{self.site}.target'

    def unit(self, name: str) -> str:
        """Returns the name of the unit of a service."""
        return f'fleet-{self.site}-{name}.service'

    def secret(self, name: str, secret: str) -> str:
        """Returns the path from which the service `name` reads a secret."""
        if self.has_credentials:
            return f'/run/credentials/{self.unit(name)}/{secret}'
        return self.kept_secret(secret)

    def kept_secret(self, secret: str) -> str:
        """Returns the path of the installed copy of a secret."""
        return f'{self.settings}/secrets/{secret}'


@dataclass(frozen=True)
class Service:
    """One unit.

    command -- ExecStart
    secrets -- names of the secrets that the unit may read
    is_watched -- whether the unit notifies systemd that it is ready and that it works
    reads -- names of other services; the unit may read their state, but not change it
    peers -- addresses and networks with which the unit may communicate, besides this computer;
             None: with all
    """

    name: str
    description: str
    command: str
    secrets: Tuple[str, ...] = ()
    is_watched: bool = True
    reads: Tuple[str, ...] = ()
    peers: Optional[Tuple[str, ...]] = None


def unit_files(services: Sequence[Service], system: System) -> Dict[str, str]:
    """Returns the texts of all units, by their names. The services start in the given order."""
    names = [system.unit(one.name) for one in services]
    units = {name: _service(one, names[:number], system)
             for number, (name, one) in enumerate(zip(names, services))}
    units[system.target] = '\n'.join((
        '[Unit]', f'Description=Fleet of the site {system.site}',
        f'Wants={" ".join(sorted(units))}', '', '[Install]', 'WantedBy=multi-user.target', ''))
    return units


def _service(service: Service, before: Sequence[str], system: System) -> str:
    own = f'{system.site}/{service.name}'
    state, logs = f'%S/fleet/{own}', f'%L/fleet/{own}'
    lines: List[str] = [
        '[Unit]', f'Description={service.description} of the site {system.site}',
        f'PartOf={system.target}', 'Wants=network-online.target',
        f'After={" ".join(("network-online.target", *before))}',
        'StartLimitIntervalSec=0',  # restarts go on for ever, but the pauses between them grow
        '', '[Service]', f'User={system.user}', f'Group={system.user}',
        f'EnvironmentFile={system.settings}/environment',
        f'Environment=HOME={state} ROS_HOME={state} ROS_LOG_DIR={logs}',
        f'StateDirectory=fleet/{own}', 'StateDirectoryMode=0700',
        f'LogsDirectory=fleet/{own}', 'LogsDirectoryMode=0700',
        f'RuntimeDirectory=fleet-{system.site}-{service.name}', 'RuntimeDirectoryMode=0700',
        'RuntimeDirectoryPreserve=yes',
        # A unit sees only its own folders, not those of other sites and units.
        'TemporaryFileSystem=%S/fleet:ro %L/fleet:ro', f'BindPaths={state} {logs}',
        *(f'BindReadOnlyPaths=-%S/fleet/{system.site}/{other}' for other in service.reads),
        f'WorkingDirectory={state}', f'ExecStart={service.command}',
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
    if service.peers is not None:
        lines += ['IPAddressDeny=any', f'IPAddressAllow={" ".join(("localhost", *service.peers))}']
    if system.has_credentials:
        lines += [f'LoadCredential={secret}:{system.kept_secret(secret)}'
                  for secret in service.secrets]
    return '\n'.join((*lines, *HARDENING, ''))
