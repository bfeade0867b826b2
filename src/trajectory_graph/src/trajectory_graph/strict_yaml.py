"""Reads YAML files strictly; an error names its line.

The reader never creates YAML objects. It only uses the text of scalars, so that a tag cannot
execute code. For each field, a function checks the value and reads it.
"""
from __future__ import annotations

import os
import re
import stat
from typing import (
    Callable,
    Container,
    Dict,
    Iterable,
    List,
    Optional,
    Sequence,
    Tuple,
    TypeVar,
    Union,
)

import yaml

LARGEST_FILE = 64 * 1024 * 1024  # bytes
DEEPEST_NESTING = 32  # collections within collections; the C loader crashes at some thousands

_Loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_PLAIN_TAGS = {f'tag:yaml.org,2002:{tag}' for tag in ('int', 'float', 'str', 'bool', 'null')}

_NUMBERS = ('tag:yaml.org,2002:int', 'tag:yaml.org,2002:float')
_NULL = 'tag:yaml.org,2002:null'

Field = Tuple[str, yaml.Node]
"""A key and its value."""
Read = TypeVar('Read')


class WrongYaml(Exception):
    """An error in a file.

    problem -- the error as a clause, e.g. `X is missing`
    line    -- the line, counted from 1; None if the error concerns the whole file
    """

    def __init__(self, problem: str, place: Union[None, int, yaml.Node] = None) -> None:
        super().__init__(problem)
        self.problem = problem
        self.line: Optional[int] = line_of(place) if isinstance(place, yaml.Node) else place


def line_of(node: yaml.Node) -> int:
    """Returns the line at which a node begins, counted from 1."""
    return node.start_mark.line + 1


def compose(path: Union[str, os.PathLike]) -> yaml.Node:
    """Returns the root of the only document in a file; raises WrongYaml."""
    return compose_data(read_file(path))


def read_file(path: Union[str, os.PathLike]) -> bytes:
    """Returns the bytes of a regular file, at most LARGEST_FILE + 1; raises WrongYaml.

    The function never blocks, even if the path is a pipe or a device.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise WrongYaml('this is not a regular file')
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), 'rb') as stream:
            return stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise WrongYaml(f'the file cannot be read ({error.strerror})') from None
    except ValueError:  # a zero byte, or characters that the file system does not have
        raise WrongYaml('no file can have this name') from None


def compose_data(data: bytes) -> yaml.Node:
    """Returns the root of the only document in the bytes of a file; raises WrongYaml."""
    if len(data) > LARGEST_FILE:
        raise WrongYaml(f'the file is larger than {LARGEST_FILE // 2 ** 20} MiB')
    try:
        if _nesting(data) > DEEPEST_NESTING:
            raise WrongYaml(f'collections are nested more than {DEEPEST_NESTING} levels deep')
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
    """Returns the error of the YAML parser without the parts that quote the file.

    A person may have given the wrong file, e.g. a file with secrets.
    """
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
    """Returns the fields of a mapping. Raises WrongYaml.

    A repeated key, a key that is a number, and a key without a value are errors. The last two
    usually come from a misspelt value: YAML reads `{X: 12,75}` as `X: 12` and a key `75`.

    The error names only keys that are `known`. Other keys may come from a file that was given by
    mistake.
    """
    if not isinstance(node, yaml.MappingNode):
        raise WrongYaml(f'{name} must be a mapping of names to values', node)
    fields: Dict[str, yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise WrongYaml(f'{name} has a key that is not a name', key)
        if key.value in fields:
            told = key.value if key.value in known else 'a key'
            raise WrongYaml(f'{told} is given twice', key)
        if key.tag in _NUMBERS:
            raise WrongYaml(f'{name} has a number, {key.value}, where the name of a field must be; '
                            'write decimal numbers with a point', key)
        if isinstance(value, yaml.ScalarNode) and value.tag == _NULL and not value.value:
            told = key.value if key.value in known else 'a key'
            raise WrongYaml(f'{told} has no value', key)
        fields[key.value] = value
    return fields


def field(fields: Dict[str, yaml.Node], key: str, where: yaml.Node) -> Field:
    """Returns a required field; raises WrongYaml if it is missing."""
    require(fields, (key,), where)
    return key, fields[key]


def require(fields: Dict[str, yaml.Node], keys: Iterable[str], where: yaml.Node) -> None:
    """Raises WrongYaml with all of the `keys` that are missing."""
    missing = [key for key in keys if key not in fields]
    if missing:
        *others, last = missing
        told = f'{", ".join(others)} and {last} are' if others else f'{last} is'
        raise WrongYaml(f'{told} missing', where)


def optional(fields: Dict[str, yaml.Node], key: str, read: Callable[[Field], Read],
             default: Read) -> Read:
    """Returns the value of a field; `default` if the field is missing."""
    return read((key, fields[key])) if key in fields else default


def items(one: Field) -> List[yaml.Node]:
    """Returns the elements of a list."""
    key, node = one
    if not isinstance(node, yaml.SequenceNode):
        raise WrongYaml(f'{key} must be a list', node)
    return list(node.value)


def listed(read: Callable[[Field], Read]) -> Callable[[Field], List[Read]]:
    """Returns a function that reads a list; `read` reads one element."""
    return lambda one: [read((f'an entry of {one[0]}', item)) for item in items(one)]


def scalar(one: Field, expected: str) -> str:
    """Returns the text of a plain value."""
    key, node = one
    if not isinstance(node, yaml.ScalarNode) or node.tag not in _PLAIN_TAGS:
        raise WrongYaml(f'{key} must be {expected}', node)
    return node.value


def _without_underscore(text: str) -> str:
    """Returns `text`; raises ValueError for e.g. `1_5`, which Python and YAML read as 15."""
    if '_' in text:
        raise ValueError
    return text


def whole(one: Field) -> int:
    """Returns a whole number of 32 bits."""
    text = scalar(one, 'a whole number')
    try:
        value = int(_without_underscore(text))
    except ValueError:
        raise WrongYaml(f'{one[0]} is {text!r}, but must be a whole number', one[1]) from None
    if abs(value) >= 2 ** 31:
        raise WrongYaml(f'{one[0]} is {text}, but must fit in 32 bits', one[1])
    return value


def real(one: Field) -> float:
    """Returns a number; NaN and infinities are allowed."""
    text = scalar(one, 'a number')
    try:
        return float(_without_underscore(text).replace('.inf', 'inf').replace('.nan', 'nan'))
    except ValueError:
        raise WrongYaml(f'{one[0]} is {text!r}, but must be a number', one[1]) from None


def text(one: Field) -> str:
    """Returns any plain text."""
    return scalar(one, 'a text')


def truth(one: Field) -> bool:
    """Returns a boolean."""
    value = scalar(one, 'true or false')
    if value.lower() not in ('true', 'false'):
        raise WrongYaml(f'{one[0]} is {value!r}, but must be true or false', one[1])
    return value.lower() == 'true'


def choice(allowed: Sequence[str], what: str) -> Callable[[Field], str]:
    """Returns a function that reads one of the `allowed` words and refuses others."""
    def read(one: Field) -> str:
        value = scalar(one, what)
        if value not in allowed:
            raise WrongYaml(f'{one[0]} is {value!r}, but must be {" or ".join(allowed)}', one[1])
        return value
    return read
