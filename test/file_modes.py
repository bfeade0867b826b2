"""The table of files, owners and modes in docs/explanation/security.md, and how to compare files with it.

    python3 -I test/file_modes.py PACKAGE.deb...     compares Debian packages with the table
"""  # noqa: E501 - the name of the page
from __future__ import annotations

import os
import re
import stat
import subprocess
import sys
import tarfile
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Tuple

PAGE = Path(__file__).resolve().parents[1] / 'docs' / 'explanation' / 'security.md'
_ROW = re.compile(r'\| `([^`]+)` \| [^|]* \| (\w+):(\w+) \| (0\d+)(?:, (.*) (0\d+))? \|')
_PROGRAM = 0o111


@dataclass(frozen=True)
class Row:
    """One row of the table.

    others -- the kinds of files with the mode `other`: folders, programs
    """

    pattern: str
    owner: str
    group: str
    mode: int
    others: str
    other: int

    def matches(self, path: str) -> bool:
        """Returns whether the row is about a path. In a pattern, `*` stands for one name, `**` for
        any number of names.
        """
        parts = re.split(r'(\*\*|\*)', self.pattern)
        return re.fullmatch(''.join({'**': '.+', '*': '[^/]+'}.get(part, re.escape(part))
                                    for part in parts), path) is not None

    def mode_of(self, mode: int) -> int:
        """Returns the mode that a file with this type and these mode bits must have."""
        is_other = 'folders' in self.others and stat.S_ISDIR(mode) or (
            'programs' in self.others and bool(mode & _PROGRAM))
        return self.other if is_other else self.mode


def rows() -> List[Row]:
    """Returns the rows of the table. For a path, the first row that matches it applies."""
    found = [Row(pattern, owner, group, int(mode, 8), others, int(other or '0', 8))
             for pattern, owner, group, mode, others, other in _ROW.findall(
                 PAGE.read_text(encoding='utf-8'))]
    assert len(found) > 10, f'{PAGE} has no table of files'
    return found


Found = Tuple[str, int, str, str]
"""Path as in the table, type and mode, owner, group."""


def differences(files: Iterable[Found]) -> List[str]:
    """Returns one line for each file that differs from the table or is not in it."""
    table, said = rows(), []
    for path, mode, owner, group in files:
        row = next((row for row in table if row.matches(path)), None)
        if row is None:
            said.append(f'{path} is in no row of the table')
        elif not stat.S_ISLNK(mode):
            found = (stat.S_IMODE(mode), owner, group)
            wanted = (row.mode_of(mode), row.owner, row.group)
            if found != wanted:
                said.append('{} is {:04o} of {}:{}, but must be {:04o} of {}:{}'.format(
                    path, *found, *wanted))
    return said


def walk(root: Path, shown: str, names: Dict[int, str]) -> Iterator[Found]:
    """Yields all files below the folder `root`.

    shown -- path that replaces the path of the folder
    names -- names of users and groups, by number
    """
    for place in sorted(root.rglob('*')):
        status = os.lstat(place)
        if not stat.S_ISSOCK(status.st_mode):
            yield (f'{shown}/{place.relative_to(root)}', status.st_mode,
                   names.get(status.st_uid, str(status.st_uid)),
                   names.get(status.st_gid, str(status.st_gid)))


def in_package(file: str) -> Iterator[Found]:
    """Yields all files in a Debian package."""
    packed = subprocess.Popen(['dpkg-deb', '--fsys-tarfile', file], stdout=subprocess.PIPE)
    with tarfile.open(fileobj=packed.stdout, mode='r|') as content:
        for member in content:
            if member.name in ('.', './'):
                continue
            kind = stat.S_IFDIR if member.isdir() else (
                stat.S_IFLNK if member.issym() else stat.S_IFREG)
            yield (f'PACKAGE/{member.name[2:]}', kind | member.mode, member.uname, member.gname)
    assert packed.wait() == 0, file


if __name__ == '__main__':
    found = [f'{Path(name).name}: {line}' for name in sys.argv[1:]
             for line in differences(in_package(name))]
    sys.exit('\n'.join(found) or None)
