"""Completes and checks requests with the site's work file: templates, groups, types of steps."""
from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Iterable, Tuple

from fleet_core.supervision.mission_book import MissionBook
from fleet_core.supervision.missions import Request, RequestRefused
from fleet_core.work.loads import fault_of_load
from fleet_core.work.site_work import SiteWork
from fleet_core.work.stations import UnknownPlace, group_of, places_of
from fleet_core.work.stops import WorkStop, dwells_of
from fleet_core.work.templates import WrongArguments, check_arguments, filled
from trajectory_graph import Graph


class WorkRequests:
    """Fills in the templates of requests, except repeated ones, and chooses places of groups.

    The resulting stops are stored, and the work file is not read again for the mission. So the
    mission does not change when the file changes.
    """

    def __init__(self, work: SiteWork, graph: Graph, book: MissionBook) -> None:
        self._work, self._graph, self._book = work, graph, book

    def complete(self, request: Request) -> Request:
        """Returns the request with the stops of its template, and with places for its groups.

        Raises RequestRefused.
        """
        if request.template:
            request = self._filled(request)
        elif request.stops:
            stops = self.placed(request.stops)
            request = replace(request, stops=stops, on_cancel=self.placed(request.on_cancel),
                              destinations=tuple(stop.place for stop in stops))
        self.check_types((*request.stops, *request.on_cancel))
        return request

    def placed(self, stops: Iterable[WorkStop]) -> Tuple[WorkStop, ...]:
        """Returns the stops, with a place for each stop that names a group.

        Raises RequestRefused for an unknown group.
        """
        return tuple(replace(stop, place=self._place_of(stop.group)) if stop.group else stop
                     for stop in stops)

    def _place_of(self, group: str) -> int:
        if not self._group(group):
            groups = [name for name in self._work.stations if self._group(name)]
            name = ''.join(one if one.isprintable() else '?' for one in group[:40])
            raise RequestRefused(f'there is no group {name!r}; there are: '
                                 f'{", ".join(groups) or "none"}')
        return self._place(group)

    def check_types(self, stops: Iterable[WorkStop]) -> None:
        """Raises RequestRefused if the site lacks the type, load or device of a step."""
        types, devices = self._work.step_types, self._work.step_devices
        for stop in stops:
            for step in stop.steps:
                if types and step.type not in types:
                    raise RequestRefused(f'there is no step type {step.type[:40]!r}; there are: '
                                         f'{", ".join(sorted(types))}')
                fault = fault_of_load(step, self._work.loads)
                if fault:
                    raise RequestRefused(f'step {step.type[:40]!r} {fault}')
                if step.device and step.device not in devices:
                    raise RequestRefused(f'there is no machine {step.device[:40]!r} among the '
                                         f'devices; there are: {", ".join(devices) or "none"}')

    def _filled(self, request: Request) -> Request:
        template = self._work.templates.get(request.template)
        if template is None:
            raise RequestRefused(f'there is no template {request.template!r}; there are: '
                                 f'{", ".join(self._work.templates) or "none"}')
        try:
            check_arguments(template, [name for name, _ in request.arguments])
            arguments = dict(request.arguments)
            stops, on_cancel = (filled(some, arguments, self._place, self._group)
                                for some in (template.stops, template.on_cancel))
        except (UnknownPlace, WrongArguments) as wrong:
            raise RequestRefused(str(wrong)) from None
        return replace(request, destinations=tuple(stop.place for stop in stops),
                       dwells=dwells_of(stops), stops=stops, on_cancel=on_cancel)

    def _group(self, word: str) -> str:
        return group_of(word, self._work.stations)

    def _place(self, word: str) -> int:
        """Returns the place that a word names.

        If the word names a group, the place is the one to which the fewest open missions go.
        """
        places = places_of(word, self._work.stations, self._graph)
        if len(places) == 1:
            return places[0]
        goals = Counter(place for mission in self._book.open for place in mission.left)
        return min(places, key=lambda place: goals[place])
