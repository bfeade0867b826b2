"""The page without its transport: its content, its records, and the outcomes of requests."""
from __future__ import annotations

import logging
import sqlite3
from dataclasses import asdict, dataclass, field
from functools import partial
from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Optional, Tuple

from fleet_core.supervision.history import HistoryLine
from fleet_page.core.acts import Act, ActKind, ActOutcome
from fleet_page.core.fleet import OPEN_STATES, MissionRequest, MissionStatus, ShownPlan
from fleet_page.core.fleet_model import FleetModel
from fleet_page.core.latencies import Histogram, ReleaseWatch
from fleet_page.core.metrics import metrics_text
from fleet_page.core.records import HistorySums, NamedKind, Records, TooManyNamed
from fleet_page.core.replay import ReplayRing
from fleet_page.core.roles import Person
from fleet_page.core.site import WallMap, site_values

Missions = Callable[[float], List[HistoryLine]]
"""Returns the missions in the journal that are open, or that have changed since a time (s since
1970). Raises JournalError. The call may be slow."""
_LOG = logging.getLogger(__name__)
REPLAY_PERIOD = 1.0   # s between two moments of the replay
SUMS_PERIOD = 20.0    # s between two additions to the sums of the history
NAMED: Dict[ActKind, NamedKind] = {
    ActKind.ADD_FAVOURITE: NamedKind.FAVOURITE, ActKind.REMOVE_FAVOURITE: NamedKind.FAVOURITE,
    ActKind.ADD_AREA: NamedKind.AREA, ActKind.REMOVE_AREA: NamedKind.AREA}
MOST_EVENTS = 20      # events of a robot that are shown, at most


class NamedWords(NamedTuple):
    """The key and the sentences of one kind of things that users store by name."""

    key: str
    unknown: str
    too_many: str
    disk: str


_WORDS: Dict[NamedKind, NamedWords] = {
    NamedKind.FAVOURITE: NamedWords(
        'favourites', 'There is no favourite {}.', 'There are too many favourites: remove some.',
        'The favourite cannot be written to the disk: {}.'),
    NamedKind.AREA: NamedWords(
        'areas', 'There is no area {}.', 'There are too many areas: remove some.',
        'The area cannot be written to the disk: {}.')}


@dataclass
class ShownSite:
    """The data of the site, except the graph.

    radii  -- m, by robot type
    fences -- fences on the robots' map: x and y (m) of a line's ends, or of an area's corners
    """

    parking: frozenset = frozenset()
    docks: frozenset = frozenset()
    walls: Optional[WallMap] = None
    radii: Dict[str, float] = field(default_factory=dict)
    fences: Tuple[Tuple[float, ...], ...] = ()


class Page:
    """All data that browsers see. One thread uses it, except for `missions`.

    There is an attribute for each kind of data, because one message may change several kinds.

    tell_areas -- is called with all areas by name, at the start and after each change
    """

    def __init__(self, records: Records, replay: ReplayRing, missions: Missions,
                 tell_areas: Callable[[Mapping[str, Any]], None] = lambda areas: None) -> None:
        self.model = FleetModel()
        self.site = ShownSite()
        self.records, self.replay, self.missions = records, replay, missions
        self.planner, self.release = Histogram(), ReleaseWatch()
        self._recorded = self._summed = 0.0
        self._troubles: Dict[str, str] = {}
        self._tell_areas = tell_areas
        self.model.site_changed()
        for kind in _WORDS:
            self._show_named(kind)

    # -- data from the fleet ----------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Does the periodic work several times per second: checks that the fleet manager still
        publishes, and writes the records.
        """
        self.model.tick(now)
        if abs(now - self._recorded) >= REPLAY_PERIOD:
            self._recorded = now
            self._keep('replay', lambda: self.replay.add(now, self.model.moment()))
        if abs(now - self._summed) >= SUMS_PERIOD:
            self._summed = now
            self._keep('history', lambda: self.records.add(now, *self.model.pop_sums()))
            self._keep('batteries', lambda: self.records.keep_charges(now, self.model.charges))
        events = self.model.pop_events()
        if events:
            self._keep('events of robots', lambda: self.records.note_events(events))

    def update_plans(self, plans: Dict[str, ShownPlan], now: float) -> None:
        """Shows the plans of all robots, and measures how long robots wait for a release."""
        self.model.update_plans(plans)
        self.release.note_plans(plans, now)

    def update_status(self, status: MissionStatus) -> None:
        """Shows the status of a mission, and updates the outcome in the audit list."""
        self.model.update_status(status)
        if status.not_done:
            self._keep('audit list', lambda: self.records.was_not_done(
                status.not_done, status.id, status.reason))
            return
        words = status.state + (f' {status.robot}' if status.robot else '') + (
            f': {status.reason}' if status.reason else '')
        if status.state not in OPEN_STATES or status.state == 'ACTIVE':
            self._keep('audit list', lambda: self.records.mission_became(status.id, words))

    def note_request(self, request: MissionRequest, sender: str, now: float) -> None:
        """Keeps the request of a mission. A request with a `sender` is added to the audit list."""
        is_new = not self.model.knows(request)
        self.model.note_request(request)
        if sender and is_new:
            act = Act(ActKind.RUN if request.template else ActKind.SEND, robot=request.robot,
                      robot_type=request.robot_type, priority=request.priority,
                      destinations=request.destinations, name=request.template,
                      arguments=request.arguments)
            self.noticed(sender, act, now, request.id)

    def noticed(self, name: str, act: Act, now: float, mission: int = 0) -> None:
        """Adds to the audit list an act that a person or program requested without the page."""
        self._keep('audit list', lambda: self.records.note(now, name, act, ActOutcome(
            True, '', mission)))

    def _keep(self, what: str, write: Callable[[], None]) -> None:
        """Writes to the page's files. If this fails, the page still shows the fleet."""
        try:
            write()
        except (OSError, sqlite3.Error) as error:
            if self._troubles.get(what) != str(error):
                _LOG.warning('The %s of the page cannot be written: %s', what, error)
            self._troubles[what] = str(error)
        else:
            self._troubles.pop(what, None)

    # -- requests of browsers ---------------------------------------------------------------------

    def done(self, person: Person, act: Act, outcome: ActOutcome, now: float) -> None:
        """Adds an act of a person and the act's outcome to the audit list."""
        self._keep('audit list', lambda: self.records.note(now, person.name, act, outcome))

    def change_named(self, act: Act) -> ActOutcome:
        """Stores or removes a favourite or an area."""
        kind = NAMED[act.kind]
        words = _WORDS[kind]
        outcome = ActOutcome(True, '')
        try:
            if act.kind in (ActKind.REMOVE_FAVOURITE, ActKind.REMOVE_AREA):
                if not self.records.remove_named(kind, act.name):
                    outcome = ActOutcome(False, words.unknown.format(act.name))
            else:
                self.records.keep_named(kind, act.name, {'edges': act.edges} if (
                    kind is NamedKind.AREA) else {
                    'destinations': act.destinations, 'robot': act.robot,
                    'robot_type': act.robot_type, 'priority': act.priority, 'stays': act.stays})
        except TooManyNamed:
            return ActOutcome(False, words.too_many)
        except sqlite3.Error as error:
            return ActOutcome(False, words.disk.format(error))
        self._show_named(kind)
        return outcome

    def _show_named(self, kind: NamedKind) -> None:
        content = self.records.named(kind)
        self.model.show_named(_WORDS[kind].key, content)
        if kind is NamedKind.AREA:
            self._tell_areas(content)

    def acknowledge(self, alarm: str, person: Person) -> ActOutcome:
        """Notes that a person has seen an alarm."""
        found = self.model.acknowledge(alarm, person.name)
        return ActOutcome(found, '' if found else 'Its cause is gone.')

    def site_values(self) -> Callable[[], Dict[str, Any]]:
        """Returns a function that makes the JSON values of the present site, in any thread."""
        site = self.site
        return partial(site_values, self.model.graph, site.parking, site.docks, site.walls,
                       dict(site.radii))

    def robot_values(self, name: str) -> Optional[Dict[str, Any]]:
        """Returns the battery and the events of a robot as JSON values; None: no such robot."""
        if name not in self.model.robots:
            return None
        return {'charges': self.records.charges(name),
                'events': [asdict(event) for event in self.records.events(name, MOST_EVENTS)]}

    def history_sums(self, since: float) -> HistorySums:
        """Returns the sums of the history since a time (s since 1970)."""
        return self.records.sums(since)

    def metrics(self, clients: int) -> str:
        """Returns the metrics in the text format of Prometheus."""
        return metrics_text(self.model, self.planner, self.release.seconds, clients)
