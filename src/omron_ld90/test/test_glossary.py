"""The glossary defines the names: each term occurs once, and replaced words no longer occur.

A class name stands for one thing in all packages.
"""
from __future__ import annotations

import ast
import io
import re
import tokenize
from functools import lru_cache
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Set

import pytest

ROOT = Path(__file__).resolve().parents[3]
GLOSSARY = ROOT / 'docs' / 'glossary.md'
MODULES = sorted(ROOT.glob('src/*/src/**/*.py'))
FLEET = ('fleet_core', 'fleet_page', 'fleet_simulation', 'graph_fleet_manager')
FLEET_ONLY = {'attempts', 'between', 'dispatcher', 'joining', 'track', 'way'}
"""Replaced words that have another meaning, and so may stand, outside these packages."""


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


@lru_cache(maxsize=None)
def identifiers() -> Dict[str, Set[str]]:
    """Plain identifiers, with names of modules, and the packages in which they occur."""
    found: Dict[str, Set[str]] = {}
    for path in MODULES:
        package, *module = path.relative_to(ROOT / 'src').with_suffix('').parts[2:]
        names = {package, *module}
        source = io.StringIO(path.read_text(encoding='utf-8'))
        names.update(token.string for token in tokenize.generate_tokens(source.readline)
                     if token.type == tokenize.NAME)
        for name in names:
            found.setdefault(plain(name), set()).add(package)
    return found


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
    found = identifiers().get(plain(word), set())
    if word in FLEET_ONLY:
        assert found and found.isdisjoint(FLEET)
    else:
        assert found == set()


# -- class names -----------------------------------------------------------------------------------

def test_a_class_name_stands_for_one_thing():
    modules: Dict[str, Set[Path]] = {}
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, ast.ClassDef) and not node.name.startswith('_'):
                modules.setdefault(node.name, set()).add(path)
    assert {name: paths for name, paths in modules.items() if len(paths) > 1} == {}


def test_a_message_to_people_names_no_class():
    """A class that is renamed in bulk must not rename a word of a sentence."""
    trees = {path: ast.parse(path.read_text(encoding='utf-8')) for path in MODULES}
    classes = {node.name for tree in trees.values() for node in ast.walk(tree)
               if isinstance(node, ast.ClassDef)}
    found = [(path.name, text) for path, tree in trees.items() for text in texts(tree)
             if ' ' in text.strip() and classes.intersection(TWO_HUMPS.findall(text))]
    assert found == []


# 'WaitState: ' is ARCL's, and 'nav_msgs/OccupancyGrid' a type of ROS
TWO_HUMPS = re.compile(r'(?<!/)\b[A-Z][a-z]+(?:[A-Z][a-z]+)+\b(?!:)')


def texts(tree: ast.AST) -> Iterator[str]:
    """The texts in a module that are no docstrings: a text that stands alone is a docstring."""
    docstrings = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and (
                id(node) not in docstrings):
            yield node.value
