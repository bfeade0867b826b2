#!/usr/bin/env python3
"""Writes the folder `debian` for scripts/make_deb.sh, from the package.xml files of the workspace.

debian_files.py SOURCE PACKAGE_TABLE

SOURCE is a copy of the repository. PACKAGE_TABLE is the package table of scripts/common.sh. Each
line of the table has the name of a package in Debian and its name under /opt/ros/noetic. Each
catkin package becomes a Debian package. The package `omron-ld90` depends on all of them.
"""
from __future__ import annotations

import email.utils
import re
import sys
import textwrap
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Mapping, Sequence, Tuple

ALL = 'omron-ld90'
"""The package that depends on all others and on ROS's commands, and contains the documentation."""

CONTROL = """\
Source: {source}
Section: misc
Priority: optional
Maintainer: {maintainer}
Build-Depends: debhelper-compat (= 13), dh-python, {build_depends}
Standards-Version: 4.6.2
Rules-Requires-Root: no
"""
BINARY = """\

Package: {name}
Architecture: {architecture}
Depends: ${{misc:Depends}}, ${{python3:Depends}}, ${{shlibs:Depends}}, {depends}
Description: {synopsis}
{text}
"""
CHANGELOG = """\
{source} ({version}) unstable; urgency=medium

  * Version {version}: CHANGELOG.md tells what is new.

 -- {maintainer}  {date}
"""
COPYRIGHT = """\
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/

Files: *
Copyright: {owner}
License: BSD-3-clause
{text}
"""
RULES = """\
#!/usr/bin/make -f
# Each catkin package is installed into the folder of its own Debian package.
%:
\tdh $@ --buildsystem=cmake --sourcedirectory=src --builddirectory=build --with python3

override_dh_auto_configure:
\tln -sf /usr/share/catkin/cmake/toplevel.cmake src/CMakeLists.txt
\tdh_auto_configure -- -DCATKIN_BUILD_BINARY_PACKAGE=ON -DCATKIN_ENABLE_TESTING=OFF \\
\t  -DPYTHON_EXECUTABLE=/usr/bin/python3

override_dh_auto_install:
{install}

override_dh_auto_test:

override_dh_installdocs:
\tdh_installdocs -p {all} README.md docs examples
\tdh_installdocs --remaining-packages

override_dh_installchangelogs:
\tdh_installchangelogs CHANGELOG.md
"""


@dataclass(frozen=True)
class Package:
    """The contents of a package.xml."""

    name: str
    version: str
    description: str
    maintainer: str
    run: Tuple[str, ...]
    """The rosdep keys and the workspace's packages that it needs at run time."""
    build: Tuple[str, ...]
    is_compiled: bool
    """Whether it has a program or a library in C or C++."""

    @property
    def debian_name(self) -> str:
        """Debian's name of the package."""
        return 'ros-' + self.name.replace('_', '-')


def read(file: Path) -> Package:
    """Reads a package.xml."""
    root = ET.parse(file).getroot()

    def text(tag: str) -> str:
        return ' '.join((root.findtext(tag) or '').split())

    def keys(*tags: str) -> Tuple[str, ...]:
        return tuple((one.text or '').strip() for tag in tags for one in root.findall(tag))

    maintainer = root.find('maintainer')
    assert maintainer is not None, file
    return Package(text('name'), text('version'), text('description'),
                   f"{maintainer.text} <{maintainer.get('email')}>",
                   keys('depend', 'exec_depend'),
                   keys('depend', 'build_depend', 'buildtool_depend'),
                   any(word in file.with_name('CMakeLists.txt').read_text()
                       for word in ('add_executable(', 'add_library(')))


def debian_names(table: str) -> Dict[str, str]:
    """Returns Debian's package names by rosdep key."""
    names: Dict[str, str] = {}
    for line in table.splitlines():
        debian, other = line.split()
        names[other[len('ros-noetic-'):].replace('-', '_') if other.startswith('ros-noetic-')
              else other] = debian
    return names


def needed(keys: Sequence[str], names: Mapping[str, str], own: Mapping[str, str]) -> List[str]:
    """Returns the run-time dependencies with Debian's names. Keys that are not in the table are
    Python modules.
    """
    return sorted({own.get(key) or names.get(key) or (
        key if key.startswith('python3-') else 'python3-' + key.replace('_', '-'))
        for key in keys})


def binary(name: str, description: str, depends: Sequence[str], is_compiled: bool = False) -> str:
    """Returns the paragraph of debian/control for one package."""
    first, _, rest = description.partition('. ')
    lines = textwrap.wrap(rest or f'{first.rstrip(".")}. A part of the LD-90 workspace.', 75)
    synopsis = first.rstrip('.').split(': ')[0] if len(first) > 78 else first.rstrip('.')
    synopsis = re.sub('^(A|An|The) ', '', synopsis)
    return BINARY.format(name=name, architecture='any' if is_compiled else 'all',
                         depends=', '.join(depends), synopsis=synopsis[:78],
                         text='\n'.join(' ' + line for line in lines))


def write(source: Path, table: str) -> None:
    """Writes the folder SOURCE/debian."""
    packages = sorted((read(file) for file in source.glob('src/*/package.xml')),
                      key=lambda package: package.name)
    versions = {package.version for package in packages}
    if len(versions) != 1:
        sys.exit(f'Packages have different versions: {", ".join(sorted(versions))}.')
    version, = versions
    maintainer = packages[0].maintainer
    names = debian_names(table)
    own = {package.name: f'{package.debian_name} (= ${{source:Version}})' for package in packages}
    build = needed([key for package in packages for key in package.build
                    if key not in own], names, {})
    control = CONTROL.format(source=ALL, maintainer=maintainer, build_depends=', '.join(build))
    control += ''.join(binary(package.debian_name, package.description,
                              needed(package.run, names, own), package.is_compiled)
                       for package in packages)
    control += binary(ALL, 'OMRON LD-90 robots and fleets of them under ROS 1. This package '
                      'installs all packages of the workspace, and their documentation.',
                      ['ros-base', 'rosbash', *sorted(own.values())])
    install = '\n'.join(
        f'\tDESTDIR=$(CURDIR)/debian/{package.debian_name} cmake '
        f'-P build/{package.name}/cmake_install.cmake' for package in packages)
    licence = (source / 'LICENSE').read_text().splitlines()
    owner = next(line for line in licence if line.startswith('Copyright'))
    files = {
        'control': control,
        'rules': RULES.format(install=install, all=ALL),
        'changelog': CHANGELOG.format(source=ALL, version=version, maintainer=maintainer,
                                      date=email.utils.formatdate()),
        'copyright': COPYRIGHT.format(
            owner=owner.replace('Copyright (c) ', ''),
            text='\n'.join(f' {line}' if line else ' .' for line in licence[4:])),
        'source/format': '3.0 (native)\n'}
    for name, content in files.items():
        file = source / 'debian' / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    (source / 'debian/rules').chmod(0o755)


if __name__ == '__main__':
    write(Path(sys.argv[1]), sys.argv[2])
