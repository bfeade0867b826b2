"""A disk of a few MB that can be filled or can fail. Needs root, in a mount namespace."""
from __future__ import annotations

import contextlib
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Iterator

_SIZE = 6 * 2 ** 20  # bytes


def why_not() -> str:
    """Returns why there can be no such disk here; empty if there can be one."""
    if not os.environ.get('LD90_MOUNTS_ALONE'):
        return 'scripts/run_tests.sh could not make a mount namespace: run it as root'
    try:
        with SmallDisk():
            return ''
    except (OSError, subprocess.CalledProcessError) as error:
        return f'no disk can be made of a file here ({getattr(error, "stderr", "") or error})'


class SmallDisk:
    """A file system in a file. `folder` is the mount point."""

    def __enter__(self) -> SmallDisk:
        with contextlib.ExitStack() as made:  # if a part cannot be made, the rest is removed
            self._place = Path(made.enter_context(tempfile.TemporaryDirectory(prefix='disk')))
            _run('mount', '-t', 'tmpfs', '-o', f'size={2 * _SIZE}', 'tmpfs', self._place)
            made.callback(_run, 'umount', '-l', self._place)
            self._image, self.folder = self._place / 'image', self._place / 'disk'
            self._image.touch()
            os.truncate(self._image, _SIZE)
            _run('mkfs.ext4', '-q', '-F', self._image)
            self.folder.mkdir()
            self._device = _run('losetup', '--find', '--show', self._image)
            made.callback(_run, 'losetup', '--detach', self._device)
            _run('mount', self._device, self.folder)
            made.callback(_run, 'umount', '-l', self.folder)
            self._made = made.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._made.close()

    @contextlib.contextmanager
    def filled(self) -> Iterator[None]:
        """Leaves no free byte during the `with` block."""
        file = self.folder / 'filling'
        with file.open('wb', buffering=0) as filling, contextlib.suppress(OSError):
            for size in (2 ** 16, 2 ** 10, 1):
                with contextlib.suppress(OSError):
                    while True:
                        filling.write(bytes(size))
        try:
            yield
        finally:
            file.unlink()

    def die(self) -> None:
        """Destroys all blocks, so that from now on nothing can be stored."""
        os.truncate(self._image, 0)
        _run('losetup', '--set-capacity', self._device)


def _run(*command: object) -> str:
    done = subprocess.run([str(word) for word in command], check=True, text=True,
                          capture_output=True)
    return done.stdout.strip()
