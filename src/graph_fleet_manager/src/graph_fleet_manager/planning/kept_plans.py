"""Which of the plans that robots own by now can still be driven, and when."""
from __future__ import annotations

from math import inf
from typing import Dict, Iterable, List, Mapping, Sequence, Tuple

from graph_fleet_manager.planning.plans import Plans
from graph_fleet_manager.planning.schedule import schedule
from graph_fleet_manager.planning.tasks import PlannedDrive, Task
from graph_fleet_manager.planning.timetable import Timetable
from graph_fleet_manager.planning.travellers import Traveller


def kept_plans(timetable: Timetable, tasks: Mapping[str, Task],
               movers: Mapping[str, Traveller]) -> Plans:
    """The plans of those who own one that can be driven, with new times in the old order.

    What stands about for ever must be booked, and nobody else. Nothing is booked here.
    """
    kept: Dict[str, Sequence[PlannedDrive]] = {
        name: plan for name, mover in movers.items()
        for plan in (tasks[name].kept,)
        if plan is not None and _can_be_driven(timetable, mover, plan)}
    strangers = [mover for name, mover in movers.items() if name not in kept]
    while strangers:  # no plan leads past a robot that has none
        passing = [name for name, plan in kept.items() if any(
            _passes(timetable, movers[name], plan, stranger) for stranger in strangers)]
        strangers = [movers[name] for name in passing]
        for name in passing:
            del kept[name]
    order: List[Tuple[float, float, str, int]] = sorted(
        (drive.start, drive.end, name, k) for name, plan in kept.items()
        for k, drive in enumerate(plan))
    plans = schedule(timetable, movers, (
        (name, timetable.network.drive(kept[name][k].edge)) for _, _, name, k in order))
    return {name: plans[name] for name in kept}


def _can_be_driven(timetable: Timetable, traveller: Traveller,
                   kept: Sequence[PlannedDrive]) -> bool:
    """Does a plan lead on from where its robot is, over open edges, past all that is booked?"""
    network, vertex = timetable.network, traveller.errand.vertex
    slots, times = timetable.slots[traveller.kind], network.times(traveller.kind)
    for edge, _, _ in kept:
        if abs(edge) not in network.edge_index or abs(edge) in network.closed:
            return False
        drive = network.drive(edge)
        if vertex >= 0 or traveller.between is None:
            begins = network.origin[drive] == vertex
        else:
            begins = drive >> 1 == traveller.between.drive >> 1
        if not begins or times[drive] == inf or slots.bookings[drive]:
            return False
        vertex = network.destination(drive)
    return True


def _passes(timetable: Timetable, owner: Traveller, kept: Sequence[PlannedDrive],
            stranger: Traveller) -> bool:
    """Does the plan of one robot lead past the place where another one stands?"""
    blocking = timetable.blocking[stranger.kind, owner.kind]
    blocked: Iterable[Tuple[int, float]]
    if stranger.between is not None:
        blocked = blocking.around_point(timetable.places_near(
            stranger.kind, owner.kind, stranger.between))
    else:
        blocked = blocking.wait(stranger.errand.vertex)
    slots = {slot for slot, _ in blocked}
    return any(timetable.network.drive(drive.edge) in slots for drive in kept)
