"""The docstring of a function begins with a verb, and no docstring is a question."""
from __future__ import annotations

import ast
import re
from functools import lru_cache
from pathlib import Path
from typing import List, NamedTuple

ROOT = Path(__file__).resolve().parents[3]
SHIPPED = sorted([*ROOT.glob('src/*/src/**/*.py'), *ROOT.glob('scripts/**/*.py')])
# The syntax of each fault, which the simulator shows as its help.
HELP = ROOT / 'src/omron_ld90_sim/src/omron_ld90_sim/interface/faults.py'
NOUNS = {'Areas', 'Bytes', 'Distances', 'Docks', 'Doors', 'Edges', 'Goals', 'Ids', 'Lines',
         'Metres', 'Minutes', 'Missions', 'Pairs', 'Pictures', 'Rectangles', 'Robots', 'Rows',
         'Seconds', 'Vertices'}
"""Plural nouns with which docstrings once began. `Names` and `Points` are left out: also verbs."""
VERB = re.compile(r'See\b|[A-Z][a-z]+s\b')


class Docstring(NamedTuple):
    place: str
    text: str
    is_of_function: bool
    """False also for a property: its docstring names a value, as that of an attribute does."""


def docstrings_in(path: Path) -> List[Docstring]:
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if not isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)):
            continue
        text = ast.get_docstring(node)
        if text:
            found.append(Docstring(f'{path.relative_to(ROOT)}:{getattr(node, "lineno", 1)}', text,
                                   is_plain_function(node)))
    return found


def is_plain_function(node: ast.AST) -> bool:
    if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        return False
    decorators = [item.attr if isinstance(item, ast.Attribute) else getattr(item, 'id', '')
                  for item in node.decorator_list]
    is_special = node.name.startswith('__') and node.name.endswith('__')
    return not is_special and not any('property' in name or name == 'setter'
                                      for name in decorators)


@lru_cache(maxsize=None)
def docstrings() -> List[Docstring]:
    return [docstring for path in SHIPPED if path != HELP for docstring in docstrings_in(path)]


def begins_with_verb(text: str) -> bool:
    word = VERB.match(text)
    return word is not None and word.group() not in NOUNS


def is_question(text: str) -> bool:
    return re.match(r'[^.]*\?(?:\s|$)', text) is not None


def test_the_docstring_of_a_function_begins_with_a_verb():
    functions = [docstring for docstring in docstrings() if docstring.is_of_function]
    assert len(functions) > 4000
    assert [(place, text.splitlines()[0]) for place, text, _ in functions
            if not begins_with_verb(text)] == [], 'begin with a verb: Returns, Sends, Notes that'


def test_no_docstring_is_a_question():
    assert [(place, text.splitlines()[0]) for place, text, _ in docstrings()
            if is_question(text)] == [], 'say what it tells: Returns whether, or Whether'


def test_a_question_and_a_noun_are_found():
    assert is_question('Is the robot there?') and is_question('The state: does\nit drive? No.')
    assert not is_question('Returns whether it drives. The prompt is `Who are you?`')
    assert begins_with_verb('Returns the robots.') and begins_with_verb('See Driver.')
    assert not any(map(begins_with_verb, ('The robots.', 'Robots that wait.', 'Return it.')))
