"""The glossary defines the names: each term occurs once, and replaced words no longer occur."""
from __future__ import annotations

import io
import re
import tokenize
from pathlib import Path
from typing import Dict, List, NamedTuple, Set

import pytest

ROOT = Path(__file__).resolve().parents[3]
GLOSSARY = ROOT / 'docs' / 'glossary.md'
PACKAGES = [ROOT / 'src' / name / 'src' / name for name in ('fleet_core', 'graph_fleet_manager')]


class Row(NamedTuple):
    term: str
    meaning: str
    replaced: List[str]


def rows() -> List[Row]:
    lines = [line for line in GLOSSARY.read_text(encoding='utf-8').splitlines()
             if line.startswith('| ')][1:]
    found = []
    for line in lines:
        term, meaning, _, replaced = (cell.strip() for cell in line.strip('|').split('|'))
        found.append(Row(re.sub(r'^\*(.*)\*$', r'\1', term), meaning,
                         re.findall(r'`([^`]+)`', replaced)))
    return found


def plain(identifier: str) -> str:
    """An identifier without case, underscores and plural s: MyTracks, _my_track -> mytrack."""
    word = identifier.lower().replace('_', '')
    return word[:-1] if word.endswith('s') else word


def identifiers() -> Dict[str, Set[str]]:
    """Plain identifiers, with names of modules, and the files in which they occur."""
    found: Dict[str, Set[str]] = {}
    for package, path in ((folder, path) for folder in PACKAGES
                          for path in folder.rglob('*.py')):
        names = {*path.relative_to(package).with_suffix('').parts}
        source = io.StringIO(path.read_text(encoding='utf-8'))
        names.update(token.string for token in tokenize.generate_tokens(source.readline)
                     if token.type == tokenize.NAME)
        for name in names:
            found.setdefault(plain(name), set()).add(str(path.relative_to(package.parent)))
    return found


IDENTIFIERS = identifiers()


def test_terms_are_sorted_and_stand_once():
    terms = [row.term.lower() for row in rows()]
    assert len(terms) > 50
    assert terms == sorted(set(terms))


@pytest.mark.parametrize('row', rows(), ids=lambda row: row.term)
def test_a_meaning_is_one_sentence(row):
    assert row.meaning.endswith('.')
    assert '. ' not in row.meaning


@pytest.mark.parametrize('word', sorted(word for row in rows() for word in row.replaced))
def test_a_replaced_word_is_no_identifier(word):
    assert IDENTIFIERS.get(plain(word), set()) == set()
