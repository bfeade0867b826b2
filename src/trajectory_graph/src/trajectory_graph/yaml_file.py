"""Trajectory graphs in the YAML files that the fleet manager's editor writes: read and written.

    Edges:
    - {CurveType: spline, Destination_ID: 2, Id: 3, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25,
       VelocityBackwards: 0.3, VelocityForward: 0.3}
    Vertices:
    - {FrameId: map/nn0, Id: 8, Label: pass, Theta: 1.64, ThetaHolomonic: 2.74, X: 4.17, Y: -3.86}

Reading is strict: every field must be there once and hold what it should. YAML's own objects are
never built: only the text of scalars is looked at, so no tag can make Python do anything. Fields
that we do not know are left alone, because the editor may write more than we need. A vertex may
also say `Dock` and `Parking` (true or false); without `Dock`, the label `dock` makes it a dock.
"""
from __future__ import annotations

import os
import tempfile
from typing import Any, Callable, Dict, List, Optional, Tuple, Union

import yaml

from trajectory_graph.errors import GraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex

LARGEST_FILE = 64 * 1024 * 1024  # bytes
DOCK_LABEL = 'dock'  # which makes a dock of a vertex that does not say whether it is one
DEEPEST_NESTING = 32  # collections within collections; the C loader crashes at some thousands

_Loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_PLAIN_TAGS = ('int', 'float', 'str', 'bool', 'null')


class _Wrong(Exception):
    """What is wrong with a node, before it is known whose it is."""

    def __init__(self, problem: str, node: yaml.Node) -> None:
        super().__init__(problem)
        self.problem = problem
        self.line = node.start_mark.line + 1


def load_graph(path: Union[str, os.PathLike]) -> Graph:
    """The graph in the YAML file `path`.

    Raises GraphError with file, line and id for a file that is missing or unreadable, is no YAML,
    lacks a field, or describes a graph that is not valid.
    """
    file = os.fspath(path)
    root = _compose(file)
    try:
        sections = _mapping(root, 'the file')
        vertices = _elements(sections, root, 'Vertices', 'vertex', _VERTEX_FIELDS, _vertex, file)
        edges = _elements(sections, root, 'Edges', 'edge', _EDGE_FIELDS, Edge, file)
    except _Wrong as wrong:
        raise GraphError(wrong.problem, file=file, line=wrong.line) from None
    lines = {('vertex', vertex.id): line for vertex, line in vertices}
    lines.update({('edge', edge.id): line for edge, line in edges})
    try:
        return Graph([vertex for vertex, _ in vertices], [edge for edge, _ in edges])
    except GraphError as error:
        raise error.located(file, lines.get((error.kind, error.id))) from None


def save_graph(graph: Graph, path: Union[str, os.PathLike], comment: str = '') -> None:
    """Writes `graph` as a file that `load_graph` reads; `comment` becomes its first line.

    An older file stays until the new one is complete. Raises OSError.
    """
    write_file(path, (f'# {comment}\n' if comment else '') + dump_graph(graph))


def dump_graph(graph: Graph) -> str:
    """The text of the file, without a comment."""
    lines = ['Edges:' if graph.edges else 'Edges: []']
    lines += [f'- {flow_mapping(edge_fields(edge))}' for edge in graph.edges.values()]
    lines.append('Vertices:')
    lines += [f'- {flow_mapping(vertex_fields(vertex))}' for vertex in graph.vertices.values()]
    return '\n'.join(lines) + '\n'


def edge_fields(edge: Edge) -> Dict[str, Any]:
    """The file's fields of an edge, by their names there."""
    return {
        'CurveType': edge.curve_type.value, 'Destination_ID': edge.destination, 'Id': edge.id,
        'Origin_ID': edge.origin, 'ParamB': edge.param_b, 'ParamF': edge.param_f,
        'VelocityBackwards': edge.velocity_backwards, 'VelocityForward': edge.velocity_forward}


def vertex_fields(vertex: Vertex) -> Dict[str, Any]:
    """The file's fields of a vertex, by their names there; None for one that is left out."""
    said_by_label = vertex.dock == (vertex.label == DOCK_LABEL)
    return {
        'Dock': None if said_by_label and not vertex.dock else vertex.dock,
        'FrameId': vertex.frame_id, 'Id': vertex.id, 'Label': vertex.label,
        'Parking': vertex.parking, 'Theta': vertex.theta,
        'ThetaHolomonic': vertex.theta_holonomic, 'X': vertex.x, 'Y': vertex.y}


def write_file(path: Union[str, os.PathLike], text: str) -> None:
    """Replaces the file `path` by a complete new one, or not at all; raises OSError."""
    target = os.path.realpath(path)
    folder, name = os.path.split(target)
    descriptor, temporary = tempfile.mkstemp(prefix=f'.{name}.', dir=folder)
    try:
        with os.fdopen(descriptor, 'w', encoding='utf-8', newline='') as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, os.stat(target).st_mode & 0o777 if os.path.exists(target) else 0o644)
        os.replace(temporary, target)
    except OSError:
        os.unlink(temporary)
        raise


def flow_mapping(fields: Dict[str, Any]) -> str:
    """`{Key: value, ...}` in one line, without the fields that are None."""
    known = {key: value for key, value in fields.items() if value is not None}
    text = yaml.dump(known, default_flow_style=True, width=10 ** 6, allow_unicode=True,
                     Dumper=getattr(yaml, 'CSafeDumper', yaml.SafeDumper))
    return text.strip()


def _vertex(dock: Optional[bool], label: str, **fields: Any) -> Vertex:
    return Vertex(label=label, dock=label == DOCK_LABEL if dock is None else dock, **fields)


def _compose(file: str) -> yaml.Node:
    try:
        with open(file, 'rb') as stream:
            data = stream.read(LARGEST_FILE + 1)
    except OSError as error:
        raise GraphError(f'the file cannot be read ({error.strerror})', file=file) from None
    if len(data) > LARGEST_FILE:
        raise GraphError(f'the file is larger than {LARGEST_FILE // 2 ** 20} MiB', file=file)
    try:
        if _nesting(data) > DEEPEST_NESTING:
            raise GraphError(f'collections are nested more than {DEEPEST_NESTING} deep', file=file)
        root = yaml.compose(data, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else None
        raise GraphError(f'this is not YAML ({error.problem or error.context})',
                         file=file, line=line) from None
    except yaml.YAMLError as error:
        raise GraphError(f'this is not YAML ({str(error).splitlines()[0]})', file=file) from None
    if root is None:
        raise GraphError('the file is empty', file=file)
    return root


def _nesting(data: bytes) -> int:
    """How deep collections are nested, counted up to one more than is allowed."""
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


def _mapping(node: yaml.Node, name: str) -> Dict[str, yaml.Node]:
    """The fields of a mapping; a key that stands there twice is wrong."""
    if not isinstance(node, yaml.MappingNode):
        raise _Wrong(f'{name} must be a mapping of names to values', node)
    fields: Dict[str, yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _Wrong(f'{name} has a key that is not a name', key)
        if key.value in fields:
            raise _Wrong(f'{key.value} stands there twice', key)
        fields[key.value] = value
    return fields


def _elements(sections: Dict[str, yaml.Node], root: yaml.Node, section: str, kind: str,
              table: _Fields, make: Callable[..., Any], file: str) -> List[Tuple[Any, int]]:
    """The vertices or edges of a section, each with its line; their ids are unique."""
    if section not in sections:
        raise _Wrong(f'{section} is missing', root)
    node = sections[section]
    if not isinstance(node, yaml.SequenceNode):
        raise _Wrong(f'{section} must be a list', node)
    lines: Dict[int, int] = {}
    elements = []
    for item in node.value:
        id = None
        try:
            fields = _mapping(item, f'an entry of {section}')
            id = _whole(_field(fields, 'Id', item))
            if id in lines:
                raise _Wrong(f'the id is used twice, first in line {lines[id]}', item)
            values = {name: read(_field(fields, key, item)) if key in fields or key not in _OPTIONAL
                      else None for key, name, read in table}
        except _Wrong as wrong:
            raise GraphError(wrong.problem, kind, id, file, wrong.line) from None
        lines[id] = item.start_mark.line + 1
        elements.append((make(id=id, **values), lines[id]))
    return elements


def _field(fields: Dict[str, yaml.Node], key: str, item: yaml.Node) -> Tuple[str, yaml.Node]:
    if key not in fields:
        raise _Wrong(f'{key} is missing', item)
    return key, fields[key]


def _scalar(field: Tuple[str, yaml.Node], expected: str) -> str:
    key, node = field
    if (not isinstance(node, yaml.ScalarNode)
            or node.tag not in {f'tag:yaml.org,2002:{tag}' for tag in _PLAIN_TAGS}):
        raise _Wrong(f'{key} must be {expected}', node)
    return node.value


def _whole(field: Tuple[str, yaml.Node]) -> int:
    text = _scalar(field, 'a whole number')
    try:
        value = int(text)
    except ValueError:
        raise _Wrong(f'{field[0]} is {text!r}, but must be a whole number', field[1]) from None
    if abs(value) >= 2 ** 31:
        raise _Wrong(f'{field[0]} is {text}, but must fit in 32 bits', field[1])
    return value


def _real(field: Tuple[str, yaml.Node]) -> float:
    text = _scalar(field, 'a number')
    try:
        return float(text.replace('.inf', 'inf').replace('.nan', 'nan'))
    except ValueError:
        raise _Wrong(f'{field[0]} is {text!r}, but must be a number', field[1]) from None


def _text(field: Tuple[str, yaml.Node]) -> str:
    return _scalar(field, 'a text')


def _truth(field: Tuple[str, yaml.Node]) -> bool:
    text = _scalar(field, 'true or false')
    if text.lower() not in ('true', 'false'):
        raise _Wrong(f'{field[0]} is {text!r}, but must be true or false', field[1])
    return text.lower() == 'true'


def _curve_type(field: Tuple[str, yaml.Node]) -> CurveType:
    text = _scalar(field, 'a curve type')
    try:
        return CurveType(text)
    except ValueError:
        allowed = ' or '.join(curve_type.value for curve_type in CurveType)
        raise _Wrong(f'{field[0]} is {text!r}, but must be {allowed}', field[1]) from None


_Fields = Tuple[Tuple[str, str, Callable[[Tuple[str, yaml.Node]], Any]], ...]

_VERTEX_FIELDS: _Fields = (
    ('Dock', 'dock', _truth),
    ('Parking', 'parking', _truth),
    ('FrameId', 'frame_id', _text),
    ('Label', 'label', _text),
    ('Theta', 'theta', _real),
    ('ThetaHolomonic', 'theta_holonomic', _real),
    ('X', 'x', _real),
    ('Y', 'y', _real),
)
_OPTIONAL = ('Dock', 'Parking')
_EDGE_FIELDS: _Fields = (
    ('CurveType', 'curve_type', _curve_type),
    ('Origin_ID', 'origin', _whole),
    ('Destination_ID', 'destination', _whole),
    ('ParamF', 'param_f', _real),
    ('ParamB', 'param_b', _real),
    ('VelocityForward', 'velocity_forward', _real),
    ('VelocityBackwards', 'velocity_backwards', _real),
)
