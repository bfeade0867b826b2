"""`scripts/backup.sh`: saves a site in one archive, and restores it.

    backup.sh save BACKUP.tar.gz FILE...      saves the given files (graph, fleet file, maps), and from ROS_HOME the journal, the closed
                                              edges, the graph in force and the page's records; the fleet may run meanwhile
    backup.sh restore BACKUP.tar.gz FOLDER    restores the given files to FOLDER, the rest to ROS_HOME; the fleet manager must not run

For the services of the site `hall`, ROS_HOME is /var/lib/fleet/hall. Passwords, tokens, private keys and all files of an unknown kind
are secrets. They are saved in BACKUP.secrets.tar.gz and are restored from there. Only their owner may read archives and restored files.
The replay of the page is not saved. A file that a restore replaces is kept as NAME.before_restore. After a restore the fleet manager
begins as with a lost journal: open missions are CANCELLED, and driving robots are stopped until all stand still.

If this program runs as root, it reads and writes in a user's folder only with the rights of that
user. Restored files belong to the owner of their folder.

Exit status 0: done; 1: not done, with one sentence that says why.
"""  # noqa: E501 - it is shown by --help
from __future__ import annotations

import os
import sqlite3
import sys
import tarfile
import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO, Dict, List, Optional, Sequence, Tuple

from fleet_core.supervision.journal_backup import copy_database, make_as_lost
from fleet_core.supervision.journal_database import JournalDatabase, JournalError
from fleet_services.file_kinds import is_secret
from fleet_services.ownership import (
    NotDone,
    as_user,
    copy_all,
    copy_regular,
    owner_of,
    put_file,
    read_as_owner,
    rename,
)
from fleet_services.state_folders import UNITS, state_folder

JOURNAL = 'graph_fleet_manager/fleet.sqlite'
DATABASES = (JOURNAL, 'fleet_page/page.sqlite')
TEXTS = ('graph_fleet_manager/closed_edges.json', 'graph_fleet_manager/graph_in_force.yaml')
KEPT = '.before_restore'
PRIVATE = 0o600  # mode of archives and of restored files
_SITE, _HOME = 'site', 'ros_home'

Contents = Dict[str, IO[bytes]]
"""Temporary files without names; the keys are their names in an archive."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or '-h' in words or '--help' in words:
        print(__doc__)
        return 0 if words else 1
    before = os.umask(0o077)
    try:
        if words[0] == 'save' and len(words) > 1:
            said = save(Path(words[1]), [Path(word) for word in words[2:]], ros_home())
        elif words[0] == 'restore' and len(words) == 3:
            said = restore(Path(words[1]), Path(words[2]), ros_home())
        else:
            raise NotDone('Wrong arguments: give save BACKUP.tar.gz FILE..., or restore '
                          'BACKUP.tar.gz FOLDER.')
    except (NotDone, JournalError) as error:
        print(error, file=sys.stderr)
        return 1
    except (OSError, sqlite3.Error, tarfile.TarError, EOFError) as error:
        print(f'The backup command failed: {error}.', file=sys.stderr)
        return 1
    finally:
        os.umask(before)
    print('\n'.join(said))
    return 0


def ros_home() -> Path:
    """Returns ROS_HOME, the folder in which nodes, or the services of a site, keep their data."""
    return Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')


def save(archive: Path, files: Sequence[Path], home: Path) -> List[str]:
    """Writes the archive, and an archive of the secrets if there are any. Returns lines about the
    contents.
    """
    by_name = {path.name: path for path in files}
    if len(by_name) < len(files):
        raise NotDone('Two of the files have the same name: rename one.')
    with ExitStack() as stack:
        public: Contents = {}
        secrets: Contents = {}
        for name, path in by_name.items():
            content = _new(stack)
            read_as_owner(path, content)
            content.seek(0)
            (secrets if is_secret(content.read()) else public)[f'{_SITE}/{name}'] = content
        public.update(_saved_state(home, stack))
        if secrets and os.geteuid() == 0 and owner_of(archive.parent) in _services(home):
            raise NotDone(f'The folder of {archive} belongs to the user of the services, which '
                          'must not read all secrets of the site: choose another folder.')
        apart = archive.with_name(archive.name.replace('.tar.gz', '') + '.secrets.tar.gz')
        if secrets and apart.exists() and not _is_of_this_command(apart):
            raise NotDone(f'The secrets would replace {apart}, which this command has not written: '
                          'move that file, or choose another name for the backup.')
        _write(archive, public)
        said = [f'{archive}: {", ".join(public) or "nothing"}.']
        if f'{_HOME}/{JOURNAL}' not in public:
            place = state_folder(home, 'graph_fleet_manager') / JOURNAL
            said.append(f'No journal is saved: there is no {place}.')
        if secrets:
            _write(apart, secrets)
            names = ', '.join(PurePosixPath(name).name for name in secrets)
            said.append(f'{apart}: {names}. Keep it elsewhere.')
    return said


def _is_of_this_command(archive: Path) -> bool:
    """Returns whether a file is an archive of secrets that an earlier backup wrote."""
    with ExitStack() as stack:
        packed = _new(stack)
        read_as_owner(archive, packed)
        packed.seek(0)
        try:
            with tarfile.open(fileobj=packed, mode='r:gz') as source:
                return all(PurePosixPath(name).parent == PurePosixPath(_SITE)
                           for name in source.getnames())
        except (OSError, tarfile.TarError, EOFError):
            return False


def _new(stack: ExitStack) -> IO[bytes]:
    """Returns a temporary file without a name, which exists until `stack` is closed."""
    return stack.enter_context(tempfile.TemporaryFile())


def _services(home: Path) -> List[int]:
    """Returns the users, except root, that own the state folders."""
    return [owner for owner in (_owner(state_folder(home, folder), home) for folder in UNITS)
            if owner]


def _owner(folder: Path, home: Path) -> int:
    """Returns the user whose rights are used for work in a folder of state: the owner of ROS_HOME,
    or, if root owns ROS_HOME, the owner of the folder.

    A user that owns ROS_HOME may have put a link in place of the folder.
    """
    return owner_of(home) or owner_of(folder)


def _saved_state(home: Path, stack: ExitStack) -> Contents:
    """Returns copies of the persistent files, each made with the rights of its folder's owner."""
    found: Contents = {}
    for name in (*DATABASES, *TEXTS):
        folder = _folder_of(name, home)
        content = _new(stack)
        as_user(_owner(folder, home), partial(_copy_state, folder / name, content))
        if content.seek(0, os.SEEK_END):
            found[f'{_HOME}/{name}'] = content
    return found


def _folder_of(name: str, home: Path) -> Path:
    """Returns the ROS_HOME in which a persistent file is."""
    folder = PurePosixPath(name).parts[0]
    return state_folder(home, folder) if folder in UNITS else home


def _copy_state(path: Path, into: IO[bytes]) -> None:
    """Copies a persistent file, if it exists. The copy of a database shows its state at one moment.
    """
    if not path.is_file():
        return
    if path.suffix != '.sqlite':
        copy_regular(path, into, follows=os.geteuid() != 0)
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / 'copy.sqlite'
        try:
            copy_database(str(path), str(copy))
        except sqlite3.Error as error:
            raise NotDone(f'{path} cannot be copied ({error}): mend it first.') from None
        with copy.open('rb') as content:
            copy_all(content, into)


def _write(archive: Path, contents: Contents) -> None:
    """Writes the archive completely; if this fails, the old archive stays."""
    with tempfile.TemporaryFile() as whole:
        with tarfile.open(fileobj=whole, mode='w:gz') as target:
            for name, content in contents.items():
                member = tarfile.TarInfo(name)
                member.mode = PRIVATE
                member.size = content.seek(0, os.SEEK_END)
                content.seek(0)
                target.addfile(member, content)
        whole.flush()
        as_user(owner_of(archive.parent), lambda: put_file(archive, whole, PRIVATE))


def restore(archive: Path, folder: Path, home: Path) -> List[str]:
    """Restores all files, or none if the archive is wrong. Returns lines about the result."""
    with ExitStack() as stack:
        packed = _new(stack)
        read_as_owner(archive, packed)
        packed.seek(0)
        places: Dict[Path, IO[bytes]] = {}
        owners: Dict[Path, int] = {}
        with tarfile.open(fileobj=packed, mode='r:gz') as source:
            for member in source.getmembers():
                within, place = _place_of(member, folder, home)
                owners[place] = _owner(within, home) if within != folder else owner_of(folder)
                content = source.extractfile(member)
                assert content is not None
                places[place] = _new(stack)
                copy_all(content, places[place])
        journal = _folder_of(JOURNAL, home) / JOURNAL
        said = _new(stack)
        if journal in places:
            as_user(owners[journal], lambda: _renew_journal(journal, places[journal], said))
        for place, content in places.items():
            as_user(owners[place], partial(_put, place, content))
        lines = [f'Restored: {", ".join(str(place) for place in places)}.']
        if journal in places:
            said.seek(0)
            lines.append(f'The journal is an old one: {said.read().decode()} open missions are '
                         'CANCELLED, and the fleet manager begins as with a lost journal.')
    return lines


def _place_of(member: tarfile.TarInfo, folder: Path, home: Path) -> Tuple[Path, Path]:
    """Returns the base folder (FOLDER or a ROS_HOME) and the path to which a file is restored.

    Raises NotDone for an unknown file.
    """
    path = PurePosixPath(member.name)
    if member.isfile() and len(path.parts) == 2 and path.parts[0] == _SITE and (
            path.name not in ('.', '..')):
        return folder, folder / path.name
    within = '/'.join(path.parts[1:])
    if member.isfile() and path.parts[:1] == (_HOME,) and within in (*DATABASES, *TEXTS):
        own = _folder_of(within, home)
        return own, own / within
    raise NotDone(f'The archive contains {member.name!r}, which is not part of a backup: choose '
                  'another archive.')


def _renew_journal(journal: Path, content: IO[bytes], said: IO[bytes]) -> None:
    """Turns a saved journal into a journal with which the fleet manager can begin.

    Raises NotDone while a fleet manager runs.
    """
    try:
        if journal.is_file():
            JournalDatabase(str(journal)).close()
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / 'copy.sqlite'
            content.seek(0)
            with copy.open('wb') as stream:
                copy_all(content, stream)
            said.write(str(make_as_lost(str(copy))).encode())
            said.flush()
            content.seek(0)
            content.truncate()
            with copy.open('rb') as renewed:
                copy_all(renewed, content)
    except JournalError as error:
        raise NotDone(str(error)) from None
    except sqlite3.Error as error:
        raise NotDone(f'The journal in the archive cannot be used ({error}): choose another '
                      'archive.') from None


def _put(place: Path, content: IO[bytes]) -> None:
    """Puts a file in its place. Keeps the old file, and also the log of an old SQLite file."""
    place.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    kept = place.with_name(place.name + KEPT)
    for ending in ('-wal', '-shm'):
        old = place.with_name(place.name + ending)
        if old.is_file():
            rename(old, kept.with_name(kept.name + ending))
    put_file(place, content, PRIVATE, kept)


if __name__ == '__main__':
    sys.exit(main())
