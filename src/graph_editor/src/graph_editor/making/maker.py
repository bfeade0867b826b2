"""Makes the trajectory graph of a site, by running all steps in their sequence."""
from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Dict, List, Sequence, Tuple

import numpy as np
from scipy import ndimage

from graph_editor.errors import SiteError
from graph_editor.floor import EVERY_NEIGHBOUR
from graph_editor.making.assembly import assemble
from graph_editor.making.axes import axes_of
from graph_editor.making.bays import add_bays
from graph_editor.making.bends import ways_of
from graph_editor.making.coverage import Coverage
from graph_editor.making.halls import add_lattices
from graph_editor.making.lanes import LaneNet
from graph_editor.making.options import Halls, MakingOptions
from graph_editor.making.places import attach_places
from graph_editor.making.pruning import merge_junctions, prune
from graph_editor.making.reaching import reach_out
from graph_editor.making.rectifying import rectify
from graph_editor.making.regaining import regain
from graph_editor.making.skeleton import skeleton_of
from graph_editor.making.squaring import square
from graph_editor.making.straightening import straighten
from graph_editor.making.tidying import prune_tails, tidy
from graph_editor.making.tips import give_tips_room
from graph_editor.making.widening import widen
from graph_editor.site import MappedSite, NamedPlace, PlaceKind
from trajectory_graph import Graph

TIMES = 3  # rounds of squaring and rectifying; several, because each step influences the other


@dataclass(frozen=True, eq=False)
class MadeGraph:
    """A made graph. `notes` are warnings for people about how it was made, one sentence each."""

    graph: Graph
    notes: Tuple[str, ...]


def make_graph(site: MappedSite, options: MakingOptions) -> MadeGraph:
    """Returns the graph of a site; raises SiteError if there is no floor for a graph.

    The shape of the lanes is computed from the floor's cells, in which walls are smoother. Then the
    exact positions of obstacles are used to give robots enough space.
    """
    exact = site.floor
    site = replace(site, floor=exact.of_cells())
    notes = list(site.notes)
    places = _placed(site, options, notes)
    starts = [place.position for place in places]
    lanes_floor = _lanes_floor(site, options, starts)
    served_floor = _joined(site.floor.clearance >= options.robot_width / 2.0, lanes_floor)
    coverage = Coverage(site.floor, served_floor, options.reach)
    axes = axes_of(site.floor)
    net = _lanes(site, lanes_floor, coverage, axes, options)
    if options.halls is Halls.LATTICE:
        net = add_lattices(net, axes, options)
        tidy(net)
    attached = attach_places(net, places, options)
    rectify(net, axes, held=attached.nodes)
    add_bays(net, coverage, axes, options)
    tidy(net, attached.nodes)
    net.floor = exact
    homes = [place.position for place in places if place.kind is PlaceKind.HOME]
    gaps = widen(net, options, attached.nodes, homes)
    give_tips_room(net, coverage, options, attached.nodes, homes)
    if not net.lanes:
        add_bays(net, coverage, axes, options)
        give_tips_room(net, coverage, options, attached.nodes, homes)
    reach_out(net, options)
    net = regain(net, gaps, attached.nodes, options, homes)
    tidy(net, attached.nodes, options.least_turning)
    ways = ways_of(net, attached.nodes, options)
    graph = assemble(net, ways, attached.nodes, site.frame_id, options)
    notes += attached.notes + [gap.note(attached.nodes.values()) for gap in gaps]
    return MadeGraph(graph, tuple(notes))


def _lanes(site: MappedSite, mask: np.ndarray, coverage: Coverage, axes: Sequence[float],
           options: MakingOptions) -> LaneNet:
    skeleton = skeleton_of(site.floor, mask)
    prune(skeleton, coverage, options)
    merge_junctions(skeleton, options)
    net = straighten(skeleton, options)
    for _ in range(TIMES):
        square(net, axes)
        tidy(net)
        rectify(net, axes)
        tidy(net)
    prune_tails(net, coverage, options.turning)
    tidy(net)
    rectify(net, axes)
    return net


def _lanes_floor(site: MappedSite, options: MakingOptions,
                 starts: List[Tuple[float, float]]) -> np.ndarray:
    """Returns the mask of the floor for lanes.

    This floor is wide enough for the robot and connected to the places. If there are no places,
    this is the largest connected part of the floor that is wide enough.
    """
    open_cells = site.floor.clearance >= options.tight
    if starts:
        return site.floor.reachable(options.tight, starts)
    parts, count = ndimage.label(open_cells, EVERY_NEIGHBOUR)
    if not count:
        raise SiteError(f'{site.name}: there is no floor on which a robot {options.robot_width:g} '
                        'm wide fits. Is the part of the map that is used (--area) right?')
    return parts == int(np.argmax(np.bincount(parts.ravel())[1:])) + 1


def _joined(open_cells: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Returns the parts of `open_cells` that `mask` touches."""
    parts, _ = ndimage.label(open_cells, EVERY_NEIGHBOUR)
    return np.isin(parts, np.unique(parts[mask & open_cells]))


def _placed(site: MappedSite, options: MakingOptions, notes: List[str]) -> List[NamedPlace]:
    """Returns the places on one connected part of the floor.

    This is the part with the largest number of docks. If several parts have this number, the number
    of goals decides, then the number of homes. Each place that robots cannot reach from this part
    gets a note.
    """
    parts: Dict[int, List[NamedPlace]] = {}
    labels, _ = ndimage.label(site.floor.clearance >= options.tight, EVERY_NEIGHBOUR)
    for place in site.places:
        part = site.floor.part_near(labels, place.position)
        if part:
            parts.setdefault(part, []).append(place)
        else:
            notes.append(f'{place.name or place.kind.value} is at a position at which a robot '
                         f'{options.robot_width:g} m wide has no space.')
    if not parts:
        if site.places:
            notes.append('No goal or dock of the map is on the floor: the graph is made for the '
                         'largest part of the floor.')
        return []
    sizes = np.bincount(labels.ravel())

    def worth(part: int) -> Tuple[int, int, int, int]:
        kinds = [place.kind for place in parts[part]]
        return (kinds.count(PlaceKind.DOCK), kinds.count(PlaceKind.GOAL),
                kinds.count(PlaceKind.HOME), int(sizes[part]))
    chosen = max(parts, key=worth)
    for part, places in parts.items():
        if part != chosen:
            notes += [f'{place.name or place.kind.value} cannot be reached from '
                      f'{parts[chosen][0].name or parts[chosen][0].kind.value} by a robot '
                      f'{options.robot_width:g} m wide: it gets no vertex.' for place in places]
    return parts[chosen]
