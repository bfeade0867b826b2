"""Two computers as two network namespaces, with a cable between them that can be pulled; needs
root.
"""
from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import subprocess
import threading
from pathlib import Path
from typing import Callable, Iterator, List, Tuple, TypeVar

Result = TypeVar('Result')

_NETWORK = 0x40000000  # CLONE_NEWNET


def why_not() -> str:
    """Returns why network namespaces cannot be made here; empty if they can be made."""
    if not shutil.which('ip'):
        return 'the program ip is not installed (Debian: iproute2)'
    try:
        with Cable():
            return ''
    except subprocess.CalledProcessError as error:
        command = ' '.join(error.cmd)
        return f'network namespaces cannot be joined ({command}: {error.stderr.strip()})'


class Cable:
    """Two namespaces with one address each, and the link between them."""

    def __init__(self) -> None:
        self.namespaces = (f'robot_{os.getpid()}', f'fleet_{os.getpid()}')
        self.addresses = ('10.199.0.5', '10.199.0.9')

    def __enter__(self) -> Cable:
        one, other = self.namespaces
        with contextlib.ExitStack() as made:  # if a part cannot be made, the rest is removed
            for name in self.namespaces:
                _ip('netns', 'add', name)
                made.callback(_ip, 'netns', 'del', name)
            _ip('-n', one, 'link', 'add', 'eth0', 'type', 'veth', 'peer', 'name', 'eth0', 'netns',
                other)
            for name, address in zip(self.namespaces, self.addresses):
                _ip('-n', name, 'address', 'add', f'{address}/24', 'dev', 'eth0')
                _ip('-n', name, 'link', 'set', 'lo', 'up')
                _ip('-n', name, 'link', 'set', 'eth0', 'up')
            self._made = made.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._made.close()

    @contextlib.contextmanager
    def pulled(self) -> Iterator[None]:
        """Takes the link down during the `with` block."""
        _ip('-n', self.namespaces[0], 'link', 'set', 'eth0', 'down')
        try:
            yield
        finally:
            _ip('-n', self.namespaces[0], 'link', 'set', 'eth0', 'up')

    @contextlib.contextmanager
    def in_radio_shadow(self) -> Iterator[None]:
        """Loses all messages during the `with` block without a sign on either side, as in a radio
        shadow.

        In contrast, the sender's own computer notices a pulled cable, and keeps trying.
        """
        neighbours = list(zip(self.namespaces, self.addresses[::-1]))
        for name, other in neighbours:  # frames then go to a computer that does not exist
            _ip('-n', name, 'neigh', 'replace', other, 'lladdr', '02:00:00:00:00:99', 'dev', 'eth0',
                'nud', 'permanent')
        try:
            yield
        finally:
            for name, other in neighbours:
                _ip('-n', name, 'neigh', 'del', other, 'dev', 'eth0')

    def bytes_sent(self) -> Tuple[int, int]:
        """Returns the bytes that have crossed the link so far, from the first and from the second
        namespace.
        """
        one, other = (inside(name, transmitted) for name in self.namespaces)
        return one, other


def transmitted(interface: str = 'eth0') -> int:
    """Returns the bytes that an interface of this thread's namespace has sent so far."""
    lines = Path('/proc/thread-self/net/dev').read_text(encoding='ascii').splitlines()
    return next(int(line.split()[9]) for line in lines if line.split()[0] == f'{interface}:')


def entering(namespace: str) -> List[str]:
    """Returns the words that make a command run in the namespace; empty if `namespace` is empty.
    """
    return ['ip', 'netns', 'exec', namespace] if namespace else []


def inside(namespace: str, act: Callable[[], Result]) -> Result:
    """Returns the result of `act`, which a thread runs in the namespace. A socket that `act` makes
    stays in the namespace.
    """
    if not namespace:
        return act()
    results: List[Result] = []

    def run() -> None:
        with open(f'/run/netns/{namespace}', encoding='ascii') as file:
            if ctypes.CDLL(None, use_errno=True).setns(file.fileno(), _NETWORK):
                raise OSError(ctypes.get_errno(), f'namespace {namespace} cannot be entered')
        results.append(act())
    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    return results[0]


def _ip(*words: str) -> None:
    subprocess.run(['ip', *words], check=True, stderr=subprocess.PIPE, text=True)
