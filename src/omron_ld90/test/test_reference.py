"""The reference and the sources name the same things: executables, parameters, topics, messages."""
from __future__ import annotations

import re
from pathlib import Path
from typing import Dict, Iterator, List, Set, Tuple

ROOT = Path(__file__).resolve().parents[3]
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]
REFERENCE = {page.name: page.read_text(encoding='utf-8')
             for page in sorted((ROOT / 'docs' / 'reference').glob('*.md'))}
SOURCES = {path: path.read_text(encoding='utf-8')
           for pattern in ('src/*/src/**/*.py', 'src/*/launch/*.launch', 'launch/*.launch')
           for path in sorted(ROOT.glob(pattern))}
EXECUTABLES = {(path.parts[-3], path.name) for path in ROOT.glob('src/*/nodes/*') if path.is_file()}
MESSAGES = {f'{path.parts[-3]}/{path.stem}' for kind in ('msg', 'srv', 'action')
            for path in ROOT.glob(f'src/*_msgs/{kind}/*.{kind}')}
#: A service of every rospy node; a program looks for it to see whether a node exists.
NOT_OURS = {'get_loggers'}
_PARAMETER_READ = re.compile(r"\(\s*'~(\w+)'")
_ROS_NAME = re.compile(r'(?:Publisher|Subscriber|rospy\.Service|ServiceProxy|SimpleActionServer|'
                       r"SimpleActionClient|ActionClient)\(\s*'([^'{]+)'")


def cells() -> Iterator[Tuple[str, List[str]]]:
    """Yields each row of the reference's tables, with its page."""
    for page, text in REFERENCE.items():
        for line in text.splitlines():
            if line.startswith('|'):
                yield page, re.split(r'(?<!\\)\|', line)[1:-1]


def words() -> Set[str]:
    """Returns all words in backticks on the reference's pages."""
    text = '\n'.join(re.sub(r'^```.*?^```$', '', page, flags=re.M | re.S)
                     for page in REFERENCE.values())
    return set(re.findall(r'`([^`\n]+)`', text))


def parameters_of_the_reference() -> Dict[str, str]:
    return {name: page for page, row in cells() for name in
            re.findall(r'`~(\w+)`', ' '.join(row[:2]))}


def found(pattern: re.Pattern[str]) -> Dict[str, str]:
    return {name: path.name for path, text in SOURCES.items() for name in pattern.findall(text)}


def test_each_parameter_that_is_read_stands_in_the_reference():
    read = found(_PARAMETER_READ)
    assert len(read) > 80
    told = parameters_of_the_reference()
    assert {name: file for name, file in read.items()
            if name not in told and name not in NOT_OURS} == {}


def test_each_parameter_of_the_reference_is_one_of_the_sources():
    known = {name for text in SOURCES.values() for name in re.findall(r'~(\w+)\b', text)}
    told = parameters_of_the_reference()
    assert len(told) > 80
    assert {name: page for name, page in told.items() if name not in known} == {}


def test_each_executable_stands_in_the_reference():
    told = {word for text in REFERENCE.values() for code in re.findall(r'`([^`\n]+)`', text)
            for word in code.split()}
    titles = {text.splitlines()[0][2:] for text in REFERENCE.values()}
    assert len(EXECUTABLES) > 30
    assert sorted(name for _, name in EXECUTABLES if name not in told | titles) == []


def test_each_program_that_a_page_starts_is_an_executable():
    started = {(package, program, page.name) for page in PAGES for package, program in
               re.findall(r'rosrun (\w+) (\w+)', page.read_text(encoding='utf-8'))}
    assert len(started) > 10
    installed = {('ld90_bringup', 'new_site')}  # a script, in install spaces
    assert [call for call in sorted(started) if call[:2] not in EXECUTABLES | installed] == []


def test_each_topic_and_service_of_the_sources_stands_in_the_reference():
    named, told = found(_ROS_NAME), {word.lstrip('/') for word in words()}
    assert len(named) > 40
    assert {name: file for name, file in named.items() if name.lstrip('/') not in told} == {}


def test_each_message_that_a_page_names_is_there():
    named = {(name, page.name) for page in PAGES
             if page.name != 'upgrading.md' for name in
             re.findall(r'\b((?:itrci_nav|omron_ld90)_msgs/[A-Z]\w+)',
                        page.read_text(encoding='utf-8'))}
    assert len(named) > 20
    assert [use for use in sorted(named) if use[0] not in MESSAGES] == []
