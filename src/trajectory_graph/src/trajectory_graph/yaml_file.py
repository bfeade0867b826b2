"""Reads and writes trajectory graphs in the YAML format of the fleet manager's editor.

    Edges:
    - {CurveType: spline, Destination_ID: 2, Id: 3, Origin_ID: 1, ParamB: 0.25, ParamF: 0.25,
       VelocityBackwards: 0.3, VelocityForward: 0.3}
    Vertices:
    - {FrameId: map/nn0, Id: 8, Label: pass, Theta: 1.64, ThetaHolomonic: 2.74, X: 4.17, Y: -3.86}

Reading is strict (see `strict_yaml`): the file must have each field once, with a valid value.
Unknown fields are ignored, because the editor may write further fields. A vertex may also have
`Dock` and `Parking` (true or false). Without `Dock`, the label `dock` makes the vertex a dock.
`FrameId`, `Label` and `ThetaHolomonic` may be missing. An edge that is a line need not have
`ParamF` and `ParamB`.
docs/reference/graph_file.md describes the format for users.
"""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, Optional, Tuple, Union

import yaml

from file_replacement import replace_file
from trajectory_graph import strict_yaml
from trajectory_graph.errors import GraphError
from trajectory_graph.graph import CurveType, Edge, Graph, Vertex
from trajectory_graph.strict_yaml import WrongYaml

DOCK_LABEL = 'dock'  # makes a vertex without the field `Dock` a dock


def load_graph(path: Union[str, os.PathLike]) -> Graph:
    """Returns the graph in the YAML file `path`.

    Raises GraphError with file, line and id if the file is missing or unreadable, is not YAML, does
    not have a field, or describes an invalid graph.
    """
    file = os.fspath(path)
    try:
        return parse_graph(strict_yaml.read_file(file), file)
    except WrongYaml as wrong:
        name = file if file.isprintable() else ascii(file)
        raise GraphError(wrong.problem, file=name, line=wrong.line) from None


def parse_graph(data: bytes, file: str) -> Graph:
    """Returns the graph in the bytes of a file with the name `file`; raises GraphError."""
    try:
        root = strict_yaml.compose_data(data)
        sections = strict_yaml.mapping(root, 'the file', _KEYS)
        strict_yaml.require(sections, ('Vertices', 'Edges'), root)
        vertices = _elements(sections, 'Vertices', 'vertex', _VERTEX_FIELDS, _vertex, file)
        edges = _elements(sections, 'Edges', 'edge', _EDGE_FIELDS, Edge, file)
    except WrongYaml as wrong:
        raise GraphError(wrong.problem, file=file, line=wrong.line) from None
    lines = {('vertex', vertex.id): line for vertex, line in vertices}
    lines.update({('edge', edge.id): line for edge, line in edges})
    try:
        return Graph([vertex for vertex, _ in vertices], [edge for edge, _ in edges])
    except GraphError as error:
        raise error.located(file, lines.get((error.kind, error.id))) from None


def save_graph(graph: Graph, path: Union[str, os.PathLike], comment: str = '') -> None:
    """Writes `graph` to a file that `load_graph` reads; `comment` becomes its first line.

    An older file is replaced only when the new one is complete. Raises OSError.
    """
    replace_file(path, (f'# {comment}\n' if comment else '') + dump_graph(graph))


def dump_graph(graph: Graph) -> str:
    """Returns the text of the file, without a comment."""
    lines = ['Edges:' if graph.edges else 'Edges: []']
    lines += [f'- {flow_mapping(edge_fields(edge))}' for edge in graph.edges.values()]
    lines.append('Vertices:')
    lines += [f'- {flow_mapping(vertex_fields(vertex))}' for vertex in graph.vertices.values()]
    return '\n'.join(lines) + '\n'


def edge_fields(edge: Edge) -> Dict[str, Any]:
    """Returns the fields of an edge, by their names in the file."""
    return {
        'CurveType': edge.curve_type.value, 'Destination_ID': edge.destination, 'Id': edge.id,
        'Origin_ID': edge.origin, 'ParamB': edge.param_b, 'ParamF': edge.param_f,
        'SectionOf': edge.section_of or None,
        'VelocityBackwards': edge.velocity_backwards, 'VelocityForward': edge.velocity_forward}


def vertex_fields(vertex: Vertex) -> Dict[str, Any]:
    """Returns the fields of a vertex, by their names in the file; None: the field is omitted."""
    said_by_label = vertex.dock == (vertex.label == DOCK_LABEL)
    return {
        'Dock': None if said_by_label else vertex.dock,
        'FrameId': vertex.frame_id, 'Id': vertex.id, 'Label': vertex.label,
        'Parking': vertex.parking, 'Theta': vertex.theta,
        'ThetaHolomonic': vertex.theta_holonomic, 'X': vertex.x, 'Y': vertex.y}


def flow_mapping(fields: Dict[str, Any]) -> str:
    """Returns `{Key: value, ...}` in one line, without the fields that are None."""
    known = {key: value for key, value in fields.items() if value is not None}
    text = yaml.dump(known, default_flow_style=True, width=10 ** 6, allow_unicode=True,
                     Dumper=getattr(yaml, 'CSafeDumper', yaml.SafeDumper))
    return text.strip()


def _vertex(theta: float, label: str = '', dock: Optional[bool] = None,
            theta_holonomic: Optional[float] = None, **fields: Any) -> Vertex:
    return Vertex(theta=theta, label=label, dock=label == DOCK_LABEL if dock is None else dock,
                  theta_holonomic=theta if theta_holonomic is None else theta_holonomic, **fields)


def _elements(sections: Dict[str, yaml.Node], section: str, kind: str, table: _Fields,
              make: Callable[..., Any], file: str) -> List[Tuple[Any, int]]:
    """Returns the vertices or edges of a section with their lines; raises GraphError."""
    lines: Dict[int, int] = {}
    elements = []
    for item in strict_yaml.items((section, sections[section])):
        id: Optional[int] = None
        try:
            fields = strict_yaml.mapping(item, f'an entry of {section}', _KEYS)
            if 'Id' in fields:
                id = strict_yaml.whole(('Id', fields['Id']))
            if id in lines:
                raise WrongYaml(f'the id is used twice, first in line {lines[id]}', item)
            strict_yaml.require(fields, ('Id', *_required(table, fields)), item)
            values = {name: read((key, fields[key])) for key, name, read in table if key in fields}
        except WrongYaml as wrong:
            raise GraphError(wrong.problem, kind, id, file, wrong.line) from None
        assert id is not None
        lines[id] = strict_yaml.line_of(item)
        elements.append((make(id=id, **values), lines[id]))
    return elements


def _curve_type(field: strict_yaml.Field) -> CurveType:
    allowed = [curve_type.value for curve_type in CurveType]
    return CurveType(strict_yaml.choice(allowed, 'a curve type')(field))


def _required(table: _Fields, fields: Dict[str, yaml.Node]) -> List[str]:
    """Returns the keys that an entry must have, apart from its id."""
    curve_type = fields.get('CurveType')
    is_line = curve_type is not None and curve_type.value == CurveType.LINE.value
    return [key for key, _, _ in table
            if key not in _OPTIONAL and not (is_line and key in _OF_SPLINES)]


_Fields = Tuple[Tuple[str, str, Callable[[strict_yaml.Field], Any]], ...]

_VERTEX_FIELDS: _Fields = (
    ('Dock', 'dock', strict_yaml.truth),
    ('Parking', 'parking', strict_yaml.truth),
    ('FrameId', 'frame_id', strict_yaml.text),
    ('Label', 'label', strict_yaml.text),
    ('Theta', 'theta', strict_yaml.real),
    ('ThetaHolomonic', 'theta_holonomic', strict_yaml.real),
    ('X', 'x', strict_yaml.real),
    ('Y', 'y', strict_yaml.real),
)
_OPTIONAL = ('Dock', 'FrameId', 'Label', 'Parking', 'SectionOf', 'ThetaHolomonic')
_OF_SPLINES = ('ParamF', 'ParamB')
_EDGE_FIELDS: _Fields = (
    ('CurveType', 'curve_type', _curve_type),
    ('Origin_ID', 'origin', strict_yaml.whole),
    ('Destination_ID', 'destination', strict_yaml.whole),
    ('ParamF', 'param_f', strict_yaml.real),
    ('ParamB', 'param_b', strict_yaml.real),
    ('SectionOf', 'section_of', strict_yaml.whole),
    ('VelocityForward', 'velocity_forward', strict_yaml.real),
    ('VelocityBackwards', 'velocity_backwards', strict_yaml.real),
)
_KEYS = {'Edges', 'Vertices', 'Id', *(key for key, _, _ in _VERTEX_FIELDS + _EDGE_FIELDS)}
