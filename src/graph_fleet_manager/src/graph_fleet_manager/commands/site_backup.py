"""`scripts/backup.sh`: saves a site in one archive, and restores it.

    backup.sh save BACKUP.tar.gz FILE...      saves the given files (graph, fleet file, maps), and from ROS_HOME the journal, the closed
                                              edges, the graph in force and the page's records; the fleet may run meanwhile
    backup.sh restore BACKUP.tar.gz FOLDER    restores the given files to FOLDER, the rest to ROS_HOME; the fleet manager must not run

A given file that only its owner may read is a secret. It is saved in BACKUP.secrets.tar.gz, which only its owner may read, and is
restored from there. The replay of the page is not saved. A file that a restore replaces is kept as NAME.before_restore. After a restore
the fleet manager begins as with a lost journal: open missions are CANCELLED, and driving robots are stopped until all stand still.

Exit status 0: done; 1: not done, with one sentence that says why.
"""  # noqa: E501 - it is shown by --help
from __future__ import annotations

import os
import shutil
import sqlite3
import sys
import tarfile
import tempfile
from pathlib import Path, PurePosixPath
from typing import IO, Dict, List, Optional, Sequence

from graph_fleet_manager.supervision.journal_backup import copy_database, make_as_lost
from graph_fleet_manager.supervision.journal_database import JournalDatabase, JournalError

JOURNAL = 'graph_fleet_manager/fleet.sqlite'
DATABASES = (JOURNAL, 'fleet_page/page.sqlite')
TEXTS = ('graph_fleet_manager/closed_edges.json', 'graph_fleet_manager/graph_in_force.yaml')
KEPT = '.before_restore'
_SITE, _HOME = 'site', 'ros_home'


class NotDone(Exception):
    """The command cannot do its work. The text is one sentence that says what to do."""


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the command; returns its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if not words or '-h' in words or '--help' in words:
        print(__doc__)
        return 0 if words else 1
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
    except (OSError, sqlite3.Error, tarfile.TarError) as error:
        print(f'The backup command failed: {error}.', file=sys.stderr)
        return 1
    print('\n'.join(said))
    return 0


def ros_home() -> Path:
    """The folder in which nodes keep their persistent files."""
    return Path(os.environ.get('ROS_HOME') or Path.home() / '.ros')


def save(archive: Path, files: Sequence[Path], home: Path) -> List[str]:
    """Writes the archive, and one of secrets if there are any. Returns lines about their contents.
    """
    by_name = {path.name: path for path in files}
    if len(by_name) < len(files):
        raise NotDone('Two of the files have the same name: rename one.')
    secrets = {name: path for name, path in by_name.items() if not path.stat().st_mode & 0o077}
    public = {name: path for name, path in by_name.items() if name not in secrets}
    with tempfile.TemporaryDirectory() as folder:
        found = {f'{_SITE}/{name}': path for name, path in public.items()}
        for name in DATABASES:
            if (home / name).is_file():
                copy = Path(folder) / name.replace('/', '_')
                copy_database(str(home / name), str(copy))
                found[f'{_HOME}/{name}'] = copy
        found.update({f'{_HOME}/{name}': home / name for name in TEXTS
                      if (home / name).is_file()})
        _write(archive, found, 0o644)
    said = [f'{archive}: {", ".join(found) or "nothing"}.']
    if f'{_HOME}/{JOURNAL}' not in found:
        said.append(f'No journal is saved: there is no {home / JOURNAL}.')
    if secrets:
        apart = archive.with_name(archive.name.replace('.tar.gz', '') + '.secrets.tar.gz')
        _write(apart, {f'{_SITE}/{name}': path for name, path in secrets.items()}, 0o600)
        said.append(f'{apart}: {", ".join(secrets)}. Keep it elsewhere.')
    return said


def _write(archive: Path, files: Dict[str, Path], mode: int) -> None:
    """Writes an archive completely, or leaves the old one."""
    unfinished = archive.with_name(f'{archive.name}.unfinished')
    with _new_file(unfinished, mode) as stream, tarfile.open(fileobj=stream, mode='w:gz') as target:
        for name, path in files.items():
            target.add(str(path.resolve()), name, recursive=False)
    os.replace(unfinished, archive)


def _new_file(path: Path, mode: int) -> IO[bytes]:
    """Creates a file with this mode from the start, so that others can never read a secret."""
    path.unlink(missing_ok=True)
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), 'wb')


def restore(archive: Path, folder: Path, home: Path) -> List[str]:
    """Restores all files, or none if the archive is wrong. Returns lines about the result."""
    with tempfile.TemporaryDirectory() as unpacked, tarfile.open(archive, 'r:gz') as source:
        places: Dict[Path, Path] = {}
        for member in source.getmembers():
            place = _place_of(member, folder, home)
            content = source.extractfile(member)
            assert content is not None
            copy = Path(unpacked) / str(len(places))
            with copy.open('wb') as stream:
                shutil.copyfileobj(content, stream)
            copy.chmod(member.mode & 0o777)
            places[place] = copy
        journal, ended = home / JOURNAL, 0
        if journal in places:
            ended = make_as_lost(str(places[journal]))
            _check_unused(journal)
        for place, copy in places.items():
            _put(copy, place)
    said = [f'Restored: {", ".join(map(str, places))}.']
    if journal in places:
        said.append(f'The journal is an old one: {ended} open missions are CANCELLED, '
                    'and the fleet manager begins as with a lost journal.')
    return said


def _place_of(member: tarfile.TarInfo, folder: Path, home: Path) -> Path:
    """The path to which a file of an archive is restored. Raises NotDone for an unknown file."""
    path = PurePosixPath(member.name)
    if member.isfile() and len(path.parts) == 2 and path.parts[0] == _SITE and (
            path.name not in ('.', '..')):
        return folder / path.name
    within = '/'.join(path.parts[1:])
    if member.isfile() and path.parts[:1] == (_HOME,) and within in (*DATABASES, *TEXTS):
        return home / within
    raise NotDone(f'The archive contains {member.name!r}, which is not part of a backup: choose '
                  'another archive.')


def _check_unused(journal: Path) -> None:
    """Raises JournalUnavailable if a fleet manager uses the journal."""
    if journal.is_file():
        JournalDatabase(str(journal)).close()


def _put(copy: Path, place: Path) -> None:
    """Puts a file in its place. The old file is kept, with the log of an SQLite file."""
    place.parent.mkdir(parents=True, exist_ok=True)
    kept = place.with_name(place.name + KEPT)
    for ending in ('', '-wal', '-shm'):
        old = place.with_name(place.name + ending)
        if old.is_file():
            os.replace(old, kept.with_name(kept.name + ending))
    unfinished = place.with_name(f'{place.name}.unfinished')
    with copy.open('rb') as content, _new_file(unfinished, copy.stat().st_mode & 0o777) as stream:
        shutil.copyfileobj(content, stream)
    os.replace(unfinished, place)


if __name__ == '__main__':
    sys.exit(main())
