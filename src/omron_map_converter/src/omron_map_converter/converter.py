"""Writes a graph into a base map: vertices as goals and dock, and fences along the edges.

`convert` edits a document in memory. `convert_file` also writes it, reads it back and checks the
result. Positions are in mm, headings in degrees.
"""
from __future__ import annotations

import math
import os
from collections import Counter
from dataclasses import dataclass
from enum import Enum
from typing import Dict, List, Optional, Set, Tuple

from omron_map import MapDocument, MapObject
from omron_map_converter.corridors import CorridorRules, Corridors, corridors_of
from omron_map_converter.fences import (
    Fences,
    fence_objects,
    is_fence,
    notes_on_fences,
    notes_on_homes,
    notes_on_places,
    notes_on_walls,
)
from omron_map_converter.goals import dock_pose, places_of
from omron_map_converter.obstacles import obstacle_points
from trajectory_graph import Graph, UnknownVertex


class ConversionError(Exception):
    """The graph and the map do not fit together; the text says why and what to do."""


class ExistingGoals(Enum):
    """The treatment of goals and docks that are already in the base map."""

    REPLACE = 'replace'
    """A goal with the name of a vertex moves to the vertex; the others stay."""
    KEEP = 'keep'
    """All goals stay where they are; only a vertex without a goal gets one."""
    DROP = 'drop'
    """All goals and docks are removed."""


@dataclass(frozen=True)
class ConversionOptions:
    """The options of a conversion."""

    dock_vertex: Optional[int] = None
    """The vertex of the dock; None: the graph has no dock."""
    dock_heading: Optional[float] = None
    """The heading that faces the station, degrees; None: from the graph, see `goals.dock_pose`."""
    existing_goals: ExistingGoals = ExistingGoals.REPLACE
    fences: Fences = Fences.AREAS
    corridors: CorridorRules = CorridorRules()


@dataclass(frozen=True)
class Conversion:
    """The result of a conversion."""

    places: Tuple[MapObject, ...]
    """The map's object for each vertex."""
    fences: Tuple[MapObject, ...]
    added: Tuple[MapObject, ...]
    removed: Tuple[MapObject, ...]
    notes: Tuple[str, ...]
    """Notes for a person about the result, one sentence each."""
    corridors: Corridors
    """The floor that the fences leave free."""


def convert(graph: Graph, document: MapDocument, options: ConversionOptions) -> Conversion:
    """Puts the graph into the document; raises ConversionError or MapError."""
    wanted = _wanted_places(graph, options)
    corridors = _corridors(graph, options)
    known = {warning.text for warning in document.warnings}
    walls = obstacle_points(document, ignored=is_fence)
    fences = fence_objects(corridors.floor, walls, options.fences)

    removed = _clear(document, wanted, options.existing_goals)
    places, added = _add_missing(document, wanted)
    notes = _new_warnings(document, known, removed) + _other_docks(document, wanted)
    old, new = Counter(filter(is_fence, document.objects)), Counter(fences)
    outdated, missing = list((old - new).elements()), list((new - old).elements())
    document.remove_all(outdated)
    document.add_all(missing)
    removed += outdated
    added += missing

    notes += notes_on_walls(graph, walls)
    if options.fences is not Fences.NONE:
        notes += notes_on_fences(graph, corridors, fences, walls)
        notes += notes_on_places(corridors, document.goals + document.docks)
        notes += notes_on_homes(corridors, document.homes)
    return Conversion(tuple(places), tuple(fences), tuple(added), tuple(removed), tuple(notes),
                      corridors)


def convert_file(graph: Graph, base_map: str, output: str,
                 options: ConversionOptions) -> Conversion:
    """Makes the map `output` from the file `base_map`, which may be the same file.

    The output is written even if nothing changes, so that it is newer than its sources.
    Raises ConversionError or MapError; `output` is replaced only by a complete map.
    """
    base = MapDocument.load(base_map)
    made = MapDocument.from_bytes(base.to_bytes(), os.fspath(output))
    conversion = convert(graph, made, options)
    made.save(output)
    check_output(base, conversion, output)
    return conversion


def check_output(base: MapDocument, conversion: Conversion, output: str) -> None:
    """Reads the map `output` and compares it with its sources; raises ConversionError.

    The objects must be those of `base`, without the removed ones and with the added ones. All other
    lines must be those of `base`; only lines about removed objects may be missing.
    """
    made = MapDocument.load(output)
    expected = Counter(map(_written, base.objects))
    expected.subtract(map(_written, conversion.removed))
    expected.update(map(_written, conversion.added))
    if Counter(map(_written, made.objects)) != +expected:
        raise ConversionError(f'{output}: the objects read back are not those that were written; '
                              'write it to another disk and compare.')
    left, right = _other_bytes(base), _other_bytes(made)
    rest = iter(left)
    only_fewer = all(line in rest for line in right)
    if not only_fewer or (len(left) != len(right) and not conversion.removed):
        raise ConversionError(f'{output}: lines of {base.name} that have nothing to do with the '
                              'graph have changed; please report this.')


def _wanted_places(graph: Graph, options: ConversionOptions) -> List[MapObject]:
    heading = options.dock_heading
    if heading is not None and not math.isfinite(heading):
        raise ConversionError(f'dock_heading is {heading}, but must be a number of degrees.')
    try:
        return places_of(graph, options.dock_vertex, options.dock_heading)
    except UnknownVertex as error:
        raise ConversionError(f'The graph has no vertex {error.id}, which dock_vertex names; '
                              'name the vertex of the dock, or none.') from error
    except ValueError as error:
        raise ConversionError(f'{error}.') from error


def _corridors(graph: Graph, options: ConversionOptions) -> Corridors:
    for id in options.corridors.edge_widths:
        if id not in graph.edges:
            raise ConversionError(f'The graph has no edge {id}, to which edge_width gives a '
                                  'width; name an edge of the graph.')
    dock = None
    if options.dock_vertex is not None:
        dock = dock_pose(graph, options.dock_vertex, options.dock_heading)
    return corridors_of(graph, options.corridors, dock)


def _clear(document: MapDocument, wanted: List[MapObject],
           existing: ExistingGoals) -> List[MapObject]:
    """Removes the goals and docks that must not stay as they are; returns the removed ones."""
    if existing is ExistingGoals.KEEP:
        return []
    by_name = {place.key: _written(place) for place in wanted}
    removed = []
    for obj in document.goals + document.docks:
        replacement = by_name.get(obj.key)
        if replacement == _written(obj):
            continue
        if replacement is not None or existing is ExistingGoals.DROP:
            removed.append(obj)
    document.remove_all(removed)
    return removed


def _add_missing(document: MapDocument,
                 wanted: List[MapObject]) -> Tuple[List[MapObject], List[MapObject]]:
    """Adds places whose names the map lacks. Returns the object of each place, and the new ones."""
    named: Dict[str, MapObject] = {}
    for obj in document.objects:
        named.setdefault(obj.key, obj)
    present = {name: obj for name, obj in named.items() if obj.is_goal or obj.is_dock}
    added = [place for place in wanted if place.key not in present]
    document.add_all(added)
    return [present.get(place.key, place) for place in wanted], added


def _new_warnings(document: MapDocument, known: Set[str], removed: List[MapObject]) -> List[str]:
    """Returns the warnings that the base map did not have.

    Warnings about removed objects are left out if an object of the same name was added.
    """
    present = {obj.key for obj in document.objects}
    back = [f'{obj.label!r}, which was removed' for obj in removed if obj.key in present]
    return [f'{warning.text[0].upper()}{warning.text[1:]}.' for warning in document.warnings
            if warning.text not in known and not any(text in warning.text for text in back)]


def _other_docks(document: MapDocument, wanted: List[MapObject]) -> List[str]:
    if not any(place.is_dock for place in wanted):
        return []
    names = {place.key for place in wanted}
    return [f'The map has another dock, {obj.label!r}: the robot may choose it when told to dock.'
            for obj in document.docks if obj.key not in names]


def _written(obj: MapObject) -> Tuple:
    """Returns the content of an object in a map file: kind, whole mm, degrees to six digits,
    texts.
    """
    theta = round(obj.theta, 6) + 0.0
    return (obj.kind, round(obj.x), round(obj.y), theta, obj.description, obj.name, obj.extent,
            obj.tail)


def _other_bytes(document: MapDocument) -> List[bytes]:
    """Returns the sections, and all lines that do not describe active objects."""
    return ([record.raw for record in document.records if record.object is None]
            + [section.raw.rstrip(b'\r\n') for section in document.sections])
