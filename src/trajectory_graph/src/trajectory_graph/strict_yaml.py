"""YAML files read strictly: what is wrong is named with its line.

YAML's own objects are never built: only the text of scalars is looked at, so no tag can make Python
do anything, and every field must hold what its reader expects.
"""
from __future__ import annotations

import os
import re
import stat
from typing import Callable, Container, Dict, List, Optional, Sequence, Tuple, TypeVar, Union

import yaml

LARGEST_FILE = 64 * 1024 * 1024  # bytes
DEEPEST_NESTING = 32  # collections within collections; the C loader crashes at some thousands

_Loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_PLAIN_TAGS = {f'tag:yaml.org,2002:{tag}' for tag in ('int', 'float', 'str', 'bool', 'null')}

Field = Tuple[str, yaml.Node]
"""A key and what stands there."""
Read = TypeVar('Read')


class WrongYaml(Exception):
    """What is wrong with a file.

    problem -- as a clause, e.g. `X is missing`
    line    -- counted from 1, None where it is about the whole file
    """

    def __init__(self, problem: str, place: Union[None, int, yaml.Node] = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.line: Optional[int] = line_of(place) if isinstance(place, yaml.Node) else place


def line_of(node: yaml.Node) -> int:
    """Line at which a node begins, counted from 1."""
    return node.start_mark.line + 1


def compose(path: Union[str, os.PathLike]) -> yaml.Node:
    """The root of the one document in a file; raises WrongYaml."""
    return compose_data(read_file(path))


def read_file(path: Union[str, os.PathLike]) -> bytes:
    """The bytes of a regular file, up to one more than is allowed; raises WrongYaml.

    It never waits: the path may lead to a pipe or a device.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise WrongYaml('this is no regular file')
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as stream:
            return stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise WrongYaml(f'the file cannot be read ({error.strerror})') from None
    except ValueError:  # a zero byte, or letters that the file system has not
        raise WrongYaml('no file can have this name') from None


def compose_data(data: bytes) -> yaml.Node:
    """The root of the one document in the bytes of a file; raises WrongYaml."""
    if len(data) > LARGEST_FILE:
        raise WrongYaml(f'the file is larger than {LARGEST_FILE // 2 ** 20} MiB')
    try:
        if _nesting(data) > DEEPEST_NESTING:
            raise WrongYaml(f'collections are nested more than {DEEPEST_NESTING} deep')
        root = yaml.compose(data, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise WrongYaml(f'this is not YAML ({_unquoted(error.problem or error.context)})',
                        mark.line + 1 if mark else None) from None
    except yaml.YAMLError as error:
        raise WrongYaml(f'this is not YAML ({str(error).splitlines()[0]})') from None
    if root is None:
        raise WrongYaml('the file is empty')
    return root


def _unquoted(problem: Optional[str]) -> str:
    """What YAML found, without the words of the file: it may be a wrong file, given by mistake."""
    return re.sub(r"""\s*(['"]).{2,}\1""", '', problem or 'no reason is known')


def _nesting(data: bytes) -> int:
    depth = deepest = 0
    for event in yaml.parse(data, Loader=_Loader):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
            deepest = max(deepest, depth)
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if deepest > DEEPEST_NESTING:
            break
    return deepest


def mapping(node: yaml.Node, name: str, known: Container[str] = ()) -> Dict[str, yaml.Node]:
    """The fields of a mapping; a key that stands there twice is wrong.

    Only a key that is `known` is named in the error: the others may be of a file given by mistake.
    """
    if not isinstance(node, yaml.MappingNode):
        raise WrongYaml(f'{name} must be a mapping of names to values', node)
    fields: Dict[str, yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise WrongYaml(f'{name} has a key that is not a name', key)
        if key.value in fields:
            told = key.value if key.value in known else 'a key'
            raise WrongYaml(f'{told} stands there twice', key)
        fields[key.value] = value
    return fields


def field(fields: Dict[str, yaml.Node], key: str, where: yaml.Node) -> Field:
    """A field that must be there."""
    if key not in fields:
        raise WrongYaml(f'{key} is missing', where)
    return key, fields[key]


def optional(fields: Dict[str, yaml.Node], key: str, read: Callable[[Field], Read],
             default: Read) -> Read:
    """What a field says, `default` where it is missing."""
    return read((key, fields[key])) if key in fields else default


def items(one: Field) -> List[yaml.Node]:
    """The elements of a list."""
    key, node = one
    if not isinstance(node, yaml.SequenceNode):
        raise WrongYaml(f'{key} must be a list', node)
    return list(node.value)


def listed(read: Callable[[Field], Read]) -> Callable[[Field], List[Read]]:
    """A reader of lists, from a reader of their elements."""
    return lambda one: [read((f'an entry of {one[0]}', item)) for item in items(one)]


def scalar(one: Field, expected: str) -> str:
    """The text of a plain value."""
    key, node = one
    if not isinstance(node, yaml.ScalarNode) or node.tag not in _PLAIN_TAGS:
        raise WrongYaml(f'{key} must be {expected}', node)
    return node.value


def whole(one: Field) -> int:
    """A whole number of 32 bits."""
    text = scalar(one, 'a whole number')
    try:
        value = int(text)
    except ValueError:
        raise WrongYaml(f'{one[0]} is {text!r}, but must be a whole number', one[1]) from None
    if abs(value) >= 2 ** 31:
        raise WrongYaml(f'{one[0]} is {text}, but must fit in 32 bits', one[1])
    return value


def real(one: Field) -> float:
    """A number, nan and infinities included."""
    text = scalar(one, 'a number')
    try:
        return float(text.replace('.inf', 'inf').replace('.nan', 'nan'))
    except ValueError:
        raise WrongYaml(f'{one[0]} is {text!r}, but must be a number', one[1]) from None


def text(one: Field) -> str:
    """Any plain text."""
    return scalar(one, 'a text')


def truth(one: Field) -> bool:
    """True or false."""
    value = scalar(one, 'true or false')
    if value.lower() not in ('true', 'false'):
        raise WrongYaml(f'{one[0]} is {value!r}, but must be true or false', one[1])
    return value.lower() == 'true'


def choice(allowed: Sequence[str], what: str) -> Callable[[Field], str]:
    """A reader of one of some words."""
    def read(one: Field) -> str:
        value = scalar(one, what)
        if value not in allowed:
            raise WrongYaml(f'{one[0]} is {value!r}, but must be {" or ".join(allowed)}', one[1])
        return value
    return read
