"""Finds the message types that the nodes of this workspace receive, in their source code.

If a node receives a type, its code passes the type as a value: to a Subscriber, to an action, or in
a table of such types. A type that is only called, published or named in annotations does not count.
"""
from __future__ import annotations

import ast
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any, Dict, Iterator, Set, Tuple

SOURCES = Path(__file__).resolve().parents[3]
_SENDERS = ('Publisher', 'isinstance', 'publisher')
_OF_EVERY_ACTION = ('actionlib_msgs.msg.GoalID', 'actionlib_msgs.msg.GoalStatusArray')
#: Types that libraries receive for the nodes that use them.
_OF_LIBRARIES = {
    'rospy': ('rosgraph_msgs.msg.Clock', 'roscpp.srv.GetLoggers', 'roscpp.srv.SetLoggerLevel'),
    'tf2_ros': ('tf2_msgs.msg.TFMessage',),
    'marker_server': ('visualization_msgs.msg.InteractiveMarkerFeedback',),
}


@lru_cache(None)
def received_types() -> Dict[str, str]:
    """Returns the received types (`package/Name`), each with a module that receives it."""
    found: Dict[str, str] = {}
    for file in sorted(SOURCES.glob('*/src/**/*.py')):
        text = file.read_text(encoding='utf-8')
        for name in _passed_on(ast.parse(text)):
            found.update((one, file.name) for one in _messages(name))
        for library, names in _OF_LIBRARIES.items():
            if f'import {library}' in text or f'.{library} import' in text:
                found.update((one, file.name) for name in names for one in _messages(name))
    return found


def _passed_on(tree: ast.AST) -> Iterator[str]:
    """Yields the full names of imported message classes that the module passes as values."""
    imported = {(name.asname or name.name): f'{node.module}.{name.name}'
                for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
                if (node.module or '').split('.')[-1] in ('msg', 'srv') for name in node.names}
    not_values: Set[int] = set()
    for node in ast.walk(tree):
        for part in _without_values(node):
            not_values.update(id(inner) for inner in ast.walk(part))
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in imported and id(node) not in not_values:
            yield imported[node.id]


def _without_values(node: ast.AST) -> Tuple[ast.AST, ...]:
    """Returns those parts of a syntax tree's node in which no class is passed as a value."""
    if isinstance(node, ast.Call):
        name = getattr(node.func, 'attr', getattr(node.func, 'id', ''))
        return (node.func, *node.args) if name in _SENDERS else (
            (node.func,) if isinstance(node.func, ast.Name) else ())
    if isinstance(node, ast.Attribute):
        return (node.value,)
    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        return (node.returns,) if node.returns else ()
    if isinstance(node, (ast.arg, ast.AnnAssign)) and node.annotation:
        return (node.annotation,)
    if isinstance(node, ast.Subscript):
        return (node.slice,)
    return ()


def _messages(name: str) -> Iterator[str]:
    """Yields the types of messages that are transmitted for a message, service or action class."""
    module, _, kind = name.rpartition('.')
    cls: Any = getattr(import_module(module), kind)
    if hasattr(cls, '_request_class'):
        yield from (cls._request_class._type, cls._response_class._type)
    elif kind.endswith('Action'):
        yield from (f'{cls._type}{part}' for part in ('Goal', 'Result', 'Feedback'))
        for one in _OF_EVERY_ACTION:
            yield from _messages(one)
    else:
        yield cls._type
