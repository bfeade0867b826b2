"""Writes the changes of an editor to a graph file, and keeps the rest of the file as it is.

- An unchanged record keeps its lines byte for byte, including comments.
- In a changed record only the changed values are rewritten. Unknown keys, sequence and layout stay.
- A new record is added at the end of its list, in the layout of the record before it.
"""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple, Union

import yaml

from file_replacement import replace_file
from trajectory_graph.editing import Draft
from trajectory_graph.errors import GraphError
from trajectory_graph.strict_yaml import WrongYaml, read_file
from trajectory_graph.yaml_file import (
    DOCK_LABEL,
    edge_fields,
    flow_mapping,
    parse_graph,
    vertex_fields,
)

_Loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
_BYTE_ORDER_MARK = '\ufeff'
_LINE_BREAKS_OF_YAML_ONLY = '\x85\u2028\u2029'
Element = Any  # Vertex or Edge
Fields = Dict[str, Any]
Edit = Tuple[int, int, str]
"""Start and end of a part of the text, and its replacement."""


class GraphFile:
    """The text of a graph file, and its graph as a draft."""

    def __init__(self, text: str, name: str) -> None:
        """Raises GraphError for a text that `load_graph` refuses; `name` is used in its message."""
        self.text = text
        self.name = name
        self.draft = Draft.of(parse_graph(text.encode('utf-8'), name))

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> GraphFile:
        """Reads the file `path`; raises GraphError."""
        name = os.fspath(path)
        try:
            return cls(read_file(path).decode('utf-8'), name)
        except WrongYaml as wrong:
            raise GraphError(wrong.problem, file=name, line=wrong.line) from None
        except UnicodeDecodeError:
            raise GraphError('this is not UTF-8', file=name) from None

    def edited(self, draft: Draft) -> GraphFile:
        """Returns the file with the graph of `draft`; raises GraphError if it is not valid."""
        draft.graph()
        mark = _BYTE_ORDER_MARK if self.text.startswith(_BYTE_ORDER_MARK) else ''
        text = self.text[len(mark):]
        root = yaml.compose(_for_marks(text), Loader=_Loader)
        edits = (_list_edits(text, root, 'Edges', edge_fields, self.draft.edges, draft.edges)
                 + _list_edits(text, root, 'Vertices', vertex_fields, self.draft.vertices,
                               draft.vertices))
        for start, end, replacement in sorted(edits, reverse=True):
            text = text[:start] + replacement + text[end:]
        try:
            edited = GraphFile(mark + text, self.name)
        except GraphError:
            edited = None
        if edited is None or edited.draft != Draft(dict(draft.vertices), dict(draft.edges)):
            raise GraphError('the edited file would not contain the edited graph, perhaps because '
                             'of YAML anchors; edit the file by hand', file=self.name)
        return edited

    def save(self, path: Union[str, os.PathLike]) -> None:
        """Replaces the file `path` by this file in one step; raises OSError."""
        replace_file(path, self.text)


def _for_marks(text: str) -> str:
    """Returns the text with blanks in place of the line breaks that only YAML knows.

    All other characters keep their positions.
    """
    for character in _LINE_BREAKS_OF_YAML_ONLY:
        text = text.replace(character, ' ')
    return text


def _list_edits(text: str, root: yaml.MappingNode, key: str, fields: Callable[[Element], Fields],
                old: Mapping[int, Element], new: Mapping[int, Element]) -> List[Edit]:
    name, node = next(pair for pair in root.value if pair[0].value == key)
    edits, staying = _known_edits(text, node, fields, old, new)
    added = [fields(element) for id, element in new.items() if id not in old]
    if not edits and not added:
        return []
    if node.flow_style:
        return [_rewritten(text, node, [fields(element) for element in new.values()])]
    if not new:
        behind_colon = text.index(':', _end_of(name)) + 1
        return [*edits, (behind_colon, behind_colon, ' []')]
    if added:
        edits.append(_new_records(text, (staying or node.value)[-1], added))
    return edits


def _known_edits(text: str, node: yaml.SequenceNode, fields: Callable[[Element], Fields],
                 old: Mapping[int, Element], new: Mapping[int, Element],
                 ) -> Tuple[List[Edit], List[yaml.MappingNode]]:
    """Returns the edits of the records that the file has, and the records that stay in the file."""
    edits: List[Edit] = []
    staying: List[yaml.MappingNode] = []
    for record in node.value:
        id = _id_of(record)
        if id not in new:
            edits.append((*_lines_of(text, record), ''))
            continue
        staying.append(record)
        if old[id] != new[id]:
            edits += _record_edits(text, record, _values(fields(old[id]), old[id]),
                                   _values(fields(new[id]), new[id]))
    return edits, staying


def _new_records(text: str, like: yaml.MappingNode, added: Sequence[Fields]) -> Edit:
    """Returns the edit that adds records after the record `like`, in its layout."""
    _, end = _lines_of(text, like)
    lines = ''.join(_like(text, like, values) for values in added)
    if not text[:end].endswith('\n'):
        lines = _line_end(text) + lines[:-len(_line_end(text))]
    return end, end, lines


def _id_of(record: yaml.MappingNode) -> int:
    return next(int(value.value) for key, value in record.value if key.value == 'Id')


def _values(fields: Fields, element: Element) -> Fields:
    """Returns the fields; `Dock` has a value even if the file omits the field."""
    return {**fields, 'Dock': element.dock} if 'Dock' in fields else fields


def _rewritten(text: str, node: yaml.SequenceNode, records: List[Fields]) -> Edit:
    """Returns the edit that rewrites a list in brackets; an empty list gets a line per record."""
    start, end = node.start_mark.index, _end_of(node)
    if node.value or not records:
        return start, end, f'[{", ".join(map(flow_mapping, records))}]'
    line_end = _line_end(text)
    return start, end, ''.join(f'{line_end}- {flow_mapping(record)}' for record in records)


def _record_edits(text: str, record: yaml.MappingNode, old: Fields, new: Fields) -> List[Edit]:
    """Returns the edits for changed values, and for added and removed keys."""
    pairs = {key.value: value for key, value in record.value}
    implied = {'Dock': new.get('Label') == DOCK_LABEL, 'FrameId': '', 'Label': '', 'ParamB': 0.0,
               'ParamF': 0.0, 'ThetaHolomonic': new.get('Theta')}
    edits: List[Edit] = []
    added = []
    for name, value in new.items():
        if (old[name] if name in pairs else implied.get(name)) == value:
            continue
        if name not in pairs:
            added.append((name, value))
        elif value is None:
            edits.append(_removal(record, name))
        else:
            edits.append((pairs[name].start_mark.index, _end_of(pairs[name]), _scalar(value)))
    if added:
        edits.append(_addition(text, record, added))
    return edits


def _addition(text: str, record: yaml.MappingNode, added: List[Tuple[str, Any]]) -> Edit:
    last_key, last_value = record.value[-1]
    end = _end_of(last_value)
    if record.flow_style:
        return end, end, ''.join(f', {name}: {_scalar(value)}' for name, value in added)
    indent = ' ' * last_key.start_mark.column
    line_end = _line_end(text)
    place = text.find('\n', end)
    lines = ''.join(f'{indent}{name}: {_scalar(value)}{line_end}' for name, value in added)
    if place < 0:
        return len(text), len(text), line_end + lines[:-len(line_end)]
    return place + 1, place + 1, lines


def _removal(record: yaml.MappingNode, name: str) -> Edit:
    """Returns the edit that removes a key, its value and the separator."""
    for k, (key, value) in enumerate(record.value):
        if key.value == name:
            if k + 1 < len(record.value):
                return key.start_mark.index, record.value[k + 1][0].start_mark.index, ''
            return _end_of(record.value[k - 1][1]), _end_of(value), ''
    raise KeyError(name)


def _like(text: str, record: yaml.MappingNode, fields: Fields) -> str:
    """Returns the lines of a new record in the layout of another record."""
    line_end = _line_end(text)
    lead = text[_dash_of(text, record):record.start_mark.index]
    if '#' in lead:
        lead = '- '
    dash = _dash_of(text, record)
    lead = text[text.rfind('\n', 0, dash) + 1:dash] + lead
    if record.flow_style:
        return f'{lead}{flow_mapping(fields)}{line_end}'
    indent = ' ' * record.start_mark.column
    return lead + indent.join(f'{name}: {_scalar(value)}{line_end}'
                              for name, value in fields.items() if value is not None)


def _dash_of(text: str, record: yaml.MappingNode) -> int:
    """Returns the position of the dash of a record in a block list."""
    dash = text.rfind('-', 0, record.start_mark.index)
    line = text.rfind('\n', 0, dash) + 1
    while text[line:dash].strip():  # the dash belongs to a comment
        dash = text.rfind('-', 0, dash)
        line = text.rfind('\n', 0, dash) + 1
    return dash


def _lines_of(text: str, record: yaml.MappingNode) -> Tuple[int, int]:
    """Returns start and end of the lines of a record, including the last line end."""
    start = text.rfind('\n', 0, _dash_of(text, record)) + 1
    end = text.find('\n', _end_of(record))
    return start, len(text) if end < 0 else end + 1


def _end_of(node: yaml.Node) -> int:
    """Returns the end of a node in the text; a block collection ends with its last value."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end_of(last[1] if isinstance(last, tuple) else last)
    return node.end_mark.index


def _scalar(value: Any) -> str:
    """Returns the text of a value, as it is written after a key; it has no line breaks."""
    return flow_mapping({'k': value})[len('{k: '):-1]


def _line_end(text: str) -> str:
    first = text.find('\n')
    return '\r\n' if first > 0 and text[first - 1] == '\r' else '\n'
