"""The glossary defines the names: each term is listed once, and replaced words are not used.

A class name stands for one thing in all packages.
"""
from __future__ import annotations

import ast
import re
from functools import lru_cache
from pathlib import Path
from typing import Dict, Iterator, List, NamedTuple, Set

import pytest

ROOT = Path(__file__).resolve().parents[3]
GLOSSARY = ROOT / 'docs' / 'glossary.md'
MODULES = sorted(ROOT.glob('src/*/src/**/*.py'))
FLEET = ('fleet_core', 'fleet_page', 'fleet_simulation', 'graph_fleet_manager')
FLEET_ONLY = {'attempts', 'between', 'dispatcher', 'joining', 'track', 'way'}
"""Replaced words that are allowed outside these packages: there they have another meaning."""


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
    """Returns an identifier in lower case, without underscores and plural s, such as `mytrack`."""
    word = identifier.lower().replace('_', '')
    return word[:-1] if word.endswith('s') else word


class Names(NamedTuple):
    """The names of the classes and functions in a module, and all its identifiers.

    texts -- the texts that are not docstrings
    """

    classes: Set[str]
    functions: Set[str]
    identifiers: Set[str]
    texts: List[str]


def identifiers_of(node: ast.AST) -> Iterator[str]:
    """Yields the identifiers in a node itself, without those of its children."""
    for field in ('id', 'attr', 'arg', 'name', 'asname', 'module'):
        value = getattr(node, field, None)
        if isinstance(value, str):
            yield from value.split('.')
    if isinstance(node, (ast.Global, ast.Nonlocal)):
        yield from node.names


def texts(nodes: List[ast.AST]) -> Iterator[str]:
    """Yields the texts that are not docstrings. A text that forms a statement is a docstring."""
    docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and (
                id(node) not in docstrings):
            yield node.value


@lru_cache(maxsize=None)
def names() -> Dict[Path, Names]:
    """Returns the names in each module."""
    found: Dict[Path, Names] = {}
    for path in MODULES:
        nodes = list(ast.walk(ast.parse(path.read_text(encoding='utf-8'))))
        found[path] = Names(
            {node.name for node in nodes if isinstance(node, ast.ClassDef)},
            {node.name for node in nodes
             if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))},
            {name for node in nodes for name in identifiers_of(node)}, list(texts(nodes)))
    return found


@lru_cache(maxsize=None)
def identifiers() -> Dict[str, Set[str]]:
    """Returns each plain identifier with the packages that use it. Names of modules count, too."""
    found: Dict[str, Set[str]] = {}
    for path in MODULES:
        package, *module = path.relative_to(ROOT / 'src').with_suffix('').parts[2:]
        for name in {package, *module, *names()[path].identifiers}:
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
        for name in names()[path].classes:
            if not name.startswith('_'):
                modules.setdefault(name, set()).add(path)
    assert {name: paths for name, paths in modules.items() if len(paths) > 1} == {}


def test_a_function_is_named_after_an_event_or_an_answer():
    """The verbs take, tell, look and see name neither an event nor a result."""
    functions = {name for found in names().values() for name in found.functions}
    assert {name for name in functions if NO_EVENT.match(name)} == set()


# Allowed: names such as take_out, take_over, take_back and take_order. `look_of` is allowed because
# it returns an appearance.
NO_EVENT = re.compile(
    r'_*(?:takes?(?!_(?:out|over|up|back|away|order)(?:_|$))|tells?|look(?!_of)|see)(?:_|$)')


def test_a_message_to_people_names_no_class():
    """Otherwise a search-and-replace for a class name could change the words of a sentence."""
    classes = {name for found in names().values() for name in found.classes}
    wrong = [(path.name, text) for path, found in names().items() for text in found.texts
             if ' ' in text.strip() and classes.intersection(TWO_HUMPS.findall(text))]
    assert wrong == []


# 'WaitState: ' is a text of ARCL, and 'nav_msgs/OccupancyGrid' is a type of ROS
TWO_HUMPS = re.compile(r'(?<!/)\b[A-Z][a-z]+(?:[A-Z][a-z]+)+\b(?!:)')
