"""All files and modules that the documents mention exist; the pages follow further rules."""
from __future__ import annotations

import ast
import functools
import re
import shutil
import subprocess
from importlib import import_module
from pathlib import Path
from typing import FrozenSet, List, Set

import pytest

ROOT = Path(__file__).resolve().parents[3]
DOCUMENTS = sorted([*ROOT.glob('*.md'), *(ROOT / 'docs').rglob('*.md'),
                    *(ROOT / 'src').glob('*/README.md')])
# A page is in the folder of its kind; pages about the whole project are above these folders.
KINDS = ('tutorials', 'how-to', 'reference', 'explanation')
OF_THE_PROJECT = ('index.md', 'glossary.md', 'performance.md', 'upgrading.md')
# These pages also mention old names.
OF_HISTORY = ('upgrading.md', 'CHANGELOG.md')
_LINK = re.compile(r'\]\(([^)#\s]+)(?:#[^)]*)?\)')
_MODULE = re.compile(r'`((?:omron_arcl|omron_map|omron_ld90|omron_ld90_sim|route_protocol|'
                     r'trajectory_graph|vda5050_(?:bench|mqtt|protocol|vehicle))(?:\.[a-z]\w*)+)`')

_TEST = re.compile(r'`((?:[\w/]*/)?(?:test_\w+|\w+_test)(?:\.py)?)`')

# A sentence must name its subject. These words name none, except `who` after a noun for people.
_OPEN_SUBJECT = re.compile(r'\b(?:who(?:ever|m)?|some(?:body|one)|any(?:body|one)|nobody|'
                           r'every(?:body|one)|whatever)\b', re.IGNORECASE)
_PEOPLE_WHO = re.compile(r'\b(?:person|people|persons|users?|readers?|engineers?) who\b',
                         re.IGNORECASE)
# Allowed quotations: words of VDA 5050, the prompt of a robot, and an example of a wrong name.
_QUOTED = ('for whatever reason', 'prompt Who are you?', "'nobody'")
PROSE = sorted([*DOCUMENTS, *(path for pattern in ('src/*/src/**/*.py', 'src/*/launch/*.launch',
                                                   'src/*/msg/*.msg', 'src/*/srv/*.srv',
                                                   'src/*/package.xml', 'src/*/config/*.yaml',
                                                   'scripts/**/*.py', 'scripts/*.sh')
                              for path in ROOT.glob(pattern))])


def name_of(document: Path) -> str:
    return str(document.relative_to(ROOT))


@pytest.mark.parametrize('document', DOCUMENTS, ids=name_of)
def test_what_is_linked_to_is_there(document: Path):
    links = [link for link in _LINK.findall(document.read_text(encoding='utf-8'))
             if '://' not in link and not is_of_workflow(link)]
    assert [link for link in links if not (document.parent / link).exists()] == []


def is_of_workflow(link: str) -> bool:
    """Returns whether a link leads to the page or badge of one of our workflows on GitHub.

    Such a link is relative to the README on GitHub.
    """
    words = re.fullmatch(r'\.\./\.\./actions/workflows/([\w.]+\.yml)(?:/badge\.svg)?', link)
    return words is not None and (ROOT / '.github/workflows' / words.group(1)).is_file()


def test_what_the_python_examples_import_is_there():
    names = [(name_of(document), node.module, alias.name) for document in DOCUMENTS
             for code in re.findall(r'```python\n(.*?)```', document.read_text(encoding='utf-8'),
                                    re.DOTALL)
             for node in ast.walk(ast.parse(code)) if isinstance(node, ast.ImportFrom)
             for alias in node.names]
    assert len(names) > 5
    assert [one for one in names if not hasattr(import_module(one[1]), one[2])] == []


def test_the_headline_figures_stand_on_the_pages_to_which_they_link():
    text = (ROOT / 'README.md').read_text(encoding='utf-8')
    head, figures, links = re.search(r'^(\| size .*)\n\|[-|]+\|\n(.*)\n(.*)$', text, re.M).groups()
    assert head == '| size | speed | proof |'
    for cell, link in zip(figures.strip('|').split('|'), _LINK.findall(links)):
        page = (ROOT / link).read_text(encoding='utf-8').replace(',', '')
        numbers = re.findall(r'\d+', cell.replace(',', ''))
        assert numbers and [one for one in numbers if not re.search(rf'\b{one}\b', page)] == []


def test_each_sentence_names_its_subject():
    found = []
    for path in PROSE:
        for number, line in enumerate(path.read_text(encoding='utf-8').splitlines(), 1):
            for words in _QUOTED:
                line = line.replace(words, '')
            if _OPEN_SUBJECT.search(_PEOPLE_WHO.sub('', line)):
                found.append(f'{name_of(path)}:{number}: {line.strip()}')
    assert len(PROSE) > 300
    assert found == [], 'name the person, program or robot instead'


def sentences_of(document: Path) -> List[str]:
    """Returns the sentences and parts of sentences of the prose; code, tables and headings do not
    count.
    """
    text = re.sub(r'```.*?```', '', document.read_text(encoding='utf-8'), flags=re.DOTALL)
    prose = '\n'.join(line if not line.startswith(('|', '#', '    ')) else ''
                      for line in text.splitlines())
    blocks = re.split(r'\n\s*(?:[-*]|\d+\.) |\n\s*\n', prose)
    return [sentence for block in blocks
            for sentence in re.split(r'(?<=[.!?:;])\)?\s+', ' '.join(block.split()))]


def length_of(sentence: str) -> int:
    """Returns the number of words: a link counts as its text, code as one word.

    Text in brackets does not count.
    """
    plain = re.sub(r'`[^`]*`', 'code', re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', sentence))
    return len(re.findall(r'\S*\w\S*', re.sub(r'\([^()]*\)', '', plain)))


def test_no_sentence_of_the_prose_has_more_than_30_words():
    assert length_of('A [long link](page.md#place) and `some code` (or not) count.') == 6
    assert [(name_of(document), sentence) for document in DOCUMENTS
            for sentence in sentences_of(document) if length_of(sentence) > 30] == []


def test_every_page_stands_in_the_folder_of_its_kind():
    pages = [page.relative_to(ROOT / 'docs') for page in (ROOT / 'docs').rglob('*.md')]
    assert [str(page) for page in pages
            if str(page) not in OF_THE_PROJECT and page.parent.as_posix() not in KINDS] == []
    assert {page.parent.as_posix() for page in pages} - {'.'} == set(KINDS)


def test_the_first_page_leads_to_every_page():
    index = ROOT / 'docs' / 'index.md'
    linked = {(index.parent / link).resolve()
              for link in _LINK.findall(index.read_text(encoding='utf-8'))}
    assert [name_of(page) for page in sorted((ROOT / 'docs').rglob('*.md'))
            if page != index and page not in linked] == []


@pytest.mark.parametrize('document', [document for document in DOCUMENTS
                                      if document.name not in OF_HISTORY], ids=name_of)
def test_every_module_that_is_named_is_there(document: Path):
    assert [name for name in _MODULE.findall(document.read_text(encoding='utf-8'))
            if not is_module(name) and not name.endswith(('.rviz', '.urdf', '.map'))] == []


def is_module(name: str) -> bool:
    """Returns whether this is a module or package of ours, or a name in a module."""
    words: List[str] = name.split('.')
    folder = ROOT / 'src' / words[0] / 'src' / Path(*words)
    return folder.is_dir() or folder.with_suffix('.py').is_file() or (
        folder.parent.with_suffix('.py').is_file())


@functools.lru_cache(maxsize=None)
def names_of_tests() -> FrozenSet[str]:
    """Returns the names and paths of all files with tests, and the names of the tests."""
    found: Set[str] = set()
    for file in (*ROOT.glob('test/*_test.py'), *ROOT.glob('src/*/test/**/test_*.py')):
        found |= {file.name, name_of(file)}
        found.update(re.findall(r'^ *def (test_\w+)\(', file.read_text(encoding='utf-8'), re.M))
    return frozenset(found)


@pytest.mark.parametrize('document', [document for document in DOCUMENTS
                                      if document.name not in OF_HISTORY], ids=name_of)
def test_every_test_that_is_named_is_there(document: Path):
    named = set(_TEST.findall(document.read_text(encoding='utf-8')))
    assert named - names_of_tests() == set()


def test_what_holds_against_an_attacker_is_shown_by_a_test_that_is_named():
    page = (ROOT / 'docs/explanation/security.md').read_text(encoding='utf-8')
    tables = re.findall(r'^\| .* \| (?:shown by|tests?) \|\n\|[-|]+\|\n((?:\|.*\|\n)+)', page, re.M)
    rows = [row for table in tables for row in table.splitlines()]
    assert len(tables) >= 8 and len(rows) >= 30
    assert [row for row in rows if not _TEST.search(row.rsplit('|', 2)[1])] == []


def test_every_package_that_is_installed_stands_with_its_licence():
    table = (ROOT / 'scripts' / 'common.sh').read_text(encoding='utf-8')
    told = (ROOT / 'docs' / 'reference' / 'dependencies.md').read_text(encoding='utf-8')
    packages = re.findall(r'^  "([\w.-]+) +[\w.-]+"$', table.split('multimaster_packages')[0], re.M)
    assert len(packages) > 30
    assert [name for name in packages if f'`{name}`' not in told] == []


def test_there_is_one_version():
    versions = {str(file.relative_to(ROOT)): re.search(pattern, file.read_text()).group(1)
                for glob, pattern in (('src/*/package.xml', r'<version>(.*)</version>'),
                                      ('src/*/setup.py', r"version='(.*?)'"),
                                      ('src/omron_jobs/src/omron_jobs/core/job_commands.py',
                                       r"(?m)^VERSION = '(.*?)'"),
                                      ('CHANGELOG.md', r'(?m)^## (\d+\.\d+\.\d+)'))
                for file in ROOT.glob(glob)}
    assert len(set(versions.values())) == 1, versions


def test_the_changelog_tells_each_release_in_150_lines_of_at_most_240_letters():
    releases = re.split(r'(?m)^## ', (ROOT / 'CHANGELOG.md').read_text(encoding='utf-8'))[1:]
    assert len(releases) >= 3
    assert {release.split('\n', 1)[0]: len(release.splitlines()) for release in releases
            if len(release.splitlines()) > 150} == {}, 'commits have the details'
    assert [line for release in releases for line in release.splitlines() if len(line) > 240] == []


def test_the_repository_holds_what_was_written_for_it_and_nothing_that_a_run_leaves():
    if shutil.which('git') is None:
        pytest.skip('git is not installed')
    listed = subprocess.run(['git', 'ls-files', '-z'], cwd=ROOT, check=False, text=True,
                            capture_output=True)
    if listed.returncode:
        pytest.skip(f'this is no clone: {listed.stderr.strip()}')
    files = listed.stdout.split('\0')
    written = [name for name in files if name and not name.startswith('docs/images/')]
    assert len(written) > 500
    assert [name for name in written if b'\0' in (ROOT / name).read_bytes()] == []
