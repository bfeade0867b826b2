"""Files of graphs that people edit: what an editor changes is written, all else stays as it is.

Records that were not touched keep their lines byte for byte, comments included. In a changed record
only the values that changed are rewritten; unknown keys, order and layout stay. New records go to
the end of their list, in the layout of the record before.
"""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple, Union

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
"""Start and end in the text, and what takes the place of what is between."""


class GraphFile:
    """The text of a graph's file, and the draft that is the graph in it."""

    def __init__(self, text: str, name: str) -> None:
        """Raises GraphError for a text that `load_graph` would refuse; `name` is for its words."""
        self.text = text
        self.name = name
        self.draft = Draft.of(parse_graph(text.encode('utf-8'), name))

    @classmethod
    def load(cls, path: Union[str, os.PathLike]) -> GraphFile:
        """The file `path`; raises GraphError."""
        name = os.fspath(path)
        try:
            return cls(read_file(path).decode('utf-8'), name)
        except WrongYaml as wrong:
            raise GraphError(wrong.problem, file=name, line=wrong.line) from None
        except UnicodeDecodeError:
            raise GraphError('this is not UTF-8', file=name) from None

    def edited(self, draft: Draft) -> GraphFile:
        """The file with the graph of `draft`; raises GraphError where that is no valid graph."""
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
            raise GraphError('the edited file would not hold the edited graph, perhaps because of '
                             'anchors in it; edit it by hand', file=self.name)
        return edited

    def save(self, path: Union[str, os.PathLike]) -> None:
        """Replaces the file `path` by this one at once; raises OSError."""
        replace_file(path, self.text)


def _for_marks(text: str) -> str:
    """The text with line breaks that only YAML knows as blanks, so that places are the same."""
    for character in _LINE_BREAKS_OF_YAML_ONLY:
        text = text.replace(character, ' ')
    return text


def _list_edits(text: str, root: yaml.MappingNode, key: str, fields: Callable[[Element], Fields],
                old: Mapping[int, Element], new: Mapping[int, Element]) -> List[Edit]:
    name, node = next(pair for pair in root.value if pair[0].value == key)
    edits: List[Edit] = []
    stays: Optional[yaml.MappingNode] = None
    for record in node.value:
        id = _id_of(record)
        if id not in new:
            edits.append((*_lines_of(text, record), ''))
            continue
        stays = record
        if old[id] != new[id]:
            edits += _record_edits(text, record, _values(fields(old[id]), old[id]),
                                   _values(fields(new[id]), new[id]))
    added = [fields(element) for id, element in new.items() if id not in old]
    if not edits and not added:
        return []
    if node.flow_style:
        return [_rewritten(text, node, [fields(element) for element in new.values()])]
    if not new:
        behind_colon = text.index(':', _end_of(name)) + 1
        return [*edits, (behind_colon, behind_colon, ' []')]
    if added:
        like = stays or node.value[-1]
        _, end = _lines_of(text, like)
        lines = ''.join(_like(text, like, values) for values in added)
        if not text[:end].endswith('\n'):
            lines = _line_end(text) + lines[:-len(_line_end(text))]
        edits.append((end, end, lines))
    return edits


def _id_of(record: yaml.MappingNode) -> int:
    return next(int(value.value) for key, value in record.value if key.value == 'Id')


def _values(fields: Fields, element: Element) -> Fields:
    """What the fields mean, also where the file need not say it."""
    return {**fields, 'Dock': element.dock} if 'Dock' in fields else fields


def _rewritten(text: str, node: yaml.SequenceNode, records: List[Fields]) -> Edit:
    """A list in brackets anew; an empty one gets a line for every record."""
    start, end = node.start_mark.index, _end_of(node)
    if node.value or not records:
        return start, end, f'[{", ".join(map(flow_mapping, records))}]'
    line_end = _line_end(text)
    return start, end, ''.join(f'{line_end}- {flow_mapping(record)}' for record in records)


def _record_edits(text: str, record: yaml.MappingNode, old: Fields, new: Fields) -> List[Edit]:
    """The values that changed, the keys that came and went."""
    pairs = {key.value: value for key, value in record.value}
    implied = {'Dock': new.get('Label') == DOCK_LABEL}
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
    """A key and its value, and what separates them from the next."""
    for k, (key, value) in enumerate(record.value):
        if key.value == name:
            if k + 1 < len(record.value):
                return key.start_mark.index, record.value[k + 1][0].start_mark.index, ''
            return _end_of(record.value[k - 1][1]), _end_of(value), ''
    raise KeyError(name)


def _like(text: str, record: yaml.MappingNode, fields: Fields) -> str:
    """A new record in the layout of another, whole lines."""
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
    """Where the dash of a record in a block list stands."""
    dash = text.rfind('-', 0, record.start_mark.index)
    line = text.rfind('\n', 0, dash) + 1
    while text[line:dash].strip():  # the dash of a comment
        dash = text.rfind('-', 0, dash)
        line = text.rfind('\n', 0, dash) + 1
    return dash


def _lines_of(text: str, record: yaml.MappingNode) -> Tuple[int, int]:
    """Where the lines of a record begin and end, the last line end included."""
    start = text.rfind('\n', 0, _dash_of(text, record)) + 1
    end = text.find('\n', _end_of(record))
    return start, len(text) if end < 0 else end + 1


def _end_of(node: yaml.Node) -> int:
    """Where a node ends in the text: a block collection where its last value does."""
    if isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        return _end_of(last[1] if isinstance(last, tuple) else last)
    return node.end_mark.index


def _scalar(value: Any) -> str:
    """A value as it stands after its key, on one line."""
    return flow_mapping({'k': value})[len('{k: '):-1]


def _line_end(text: str) -> str:
    first = text.find('\n')
    return '\r\n' if first > 0 and text[first - 1] == '\r' else '\n'
