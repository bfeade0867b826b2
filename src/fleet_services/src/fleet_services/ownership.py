"""Does work in the folders of other users with their rights, never with the rights of root.

A user can put a link into its own folder at any time. A program with the rights of root that works
in this folder would read or write the file that the link names. A process with the rights of the
user cannot do more than the user.
"""
from __future__ import annotations

import grp
import os
import pwd
import stat
import sys
import traceback
from pathlib import Path
from typing import IO, Callable, List, Optional, Tuple

_BLOCK = 1 << 20
_MOST_LINKS = 10
_NOBODY = 65534  # group of a user that the system does not know


class NotDone(Exception):
    """A command cannot do its work. The text is one sentence that says what to do."""


def owner_of(folder: Path) -> int:
    """Returns the owner of a folder, or of the nearest existing folder above it."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return folder.stat().st_uid


def as_user(user: int, work: Callable[[], None], group: int = _NOBODY) -> None:
    """Calls `work` with the rights of a user; raises NotDone with the reason of a failure.

    Under root, `work` runs in a separate process, which gives up the rights of root. Any other
    caller has no rights to give up, so `work` runs in this process.

    group -- the group to use if this system does not know the user, such as a user of an image
    """
    if os.geteuid() != 0 or user == 0:
        work()
        return
    sys.stdout.flush()
    sys.stderr.flush()
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        os._exit(_work_as(user, group, work, writer))
    os.close(writer)
    with os.fdopen(reader, 'rb') as said:
        problem = said.read().decode()
    if os.waitpid(child, 0)[1]:
        raise NotDone(problem or f'A process of the user {user} was killed.')


def _work_as(user: int, group: int, work: Callable[[], None], writer: int) -> int:
    """Runs in the child process: gives up the rights of root, works, and reports a failure."""
    try:
        group, groups = _groups_of(user, group)
        os.setgroups(groups)
        os.setresgid(group, group, group)
        os.setresuid(user, user, user)
        work()
    except (NotDone, OSError) as error:
        os.write(writer, str(error).encode(errors='replace'))
    except BaseException:
        os.write(writer, traceback.format_exc().encode(errors='replace'))
    else:
        return 0
    return 1


def _groups_of(user: int, group: int) -> Tuple[int, List[int]]:
    try:
        known = pwd.getpwuid(user)
    except KeyError:
        return (group if group > 0 else _NOBODY), []
    return known.pw_gid, [one.gr_gid for one in grp.getgrall() if known.pw_name in one.gr_mem]


def read_as_owner(path: Path, into: IO[bytes]) -> None:
    """Copies a file with the rights of the owner of its directory entry; raises NotDone, OSError.

    A link that root owns is followed with the rights of root. A link of another user is followed
    with the rights of that user.
    """
    for _ in range(_MOST_LINKS):
        entry = os.lstat(path)
        if not (os.geteuid() == 0 and entry.st_uid == 0 and stat.S_ISLNK(entry.st_mode)):
            break
        path = path.parent / os.readlink(path)
    follows = os.geteuid() != 0 or entry.st_uid != 0
    as_user(entry.st_uid, lambda: copy_regular(path, into, follows))


def copy_regular(path: Path, into: IO[bytes], follows: bool = False) -> None:
    """Copies a regular file that has only one name.

    Reading another kind of file may never end, and a second name (hard link) may be a trap.
    """
    flags = os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC | (0 if follows else os.O_NOFOLLOW)
    with open(os.open(path, flags), 'rb') as source:
        status = os.fstat(source.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise NotDone(f'{path} is no regular file: name another file.')
        if not follows and status.st_nlink != 1 and os.geteuid() == 0:
            raise NotDone(f'{path} has a second name, which may belong to another user: name a '
                          'copy of it.')
        copy_all(source, into)


def copy_all(source: IO[bytes], into: IO[bytes]) -> None:
    """Copies the rest of a file, and flushes the copy for other processes that have it open."""
    block = source.read(_BLOCK)
    while block:
        into.write(block)
        block = source.read(_BLOCK)
    into.flush()


def put_file(place: Path, content: IO[bytes], mode: int, kept: Optional[Path] = None) -> None:
    """Writes a file completely; if this fails, the old file stays unchanged. If the name belongs to
    a link, the link is replaced, not followed.

    kept -- the old file gets this name; None: the old file is overwritten
    """
    unfinished = place.with_name(f'{place.name}.unfinished')
    unfinished.unlink(missing_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    with open(os.open(unfinished, flags, mode), 'wb') as stream:
        os.fchmod(stream.fileno(), mode)
        content.seek(0)
        copy_all(content, stream)
        os.fsync(stream.fileno())
    if kept is not None and os.path.lexists(place):
        rename(place, kept)
    rename(unfinished, place)


def rename(source: Path, target: Path) -> None:
    """Renames a file, folder or link within a file system; a link is never followed."""
    os.replace(source, target)
