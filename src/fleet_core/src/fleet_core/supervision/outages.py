"""Outages: why a robot cannot be given anything to drive, and how each outage ends."""
from __future__ import annotations

from enum import Enum
from typing import AbstractSet, FrozenSet, Mapping, NamedTuple, Optional

from route_protocol.values import EpochCause, Reason, ReasonCode


class Outage(Enum):
    """What keeps a robot from working. The values are shown to people."""

    UNSEEN = 'it has not reported yet'
    ABSENT = 'it was declared absent'
    SILENT = 'it does not report'
    DEAF = 'it reports, but does not answer its orders'
    CLOCK = 'its clock differs too much'
    LOST_LINK = 'the link to it was lost'
    STOPPED = 'emergency stop'
    TOO_NEAR = 'it is too near to another robot'
    TAKEN_OVER = 'another giver drives it'
    FAILED = 'its route failed'
    OFF_GRAPH = 'it is off the graph'
    OUT_OF_SERVICE = 'it was taken out of service'

    @property
    def needs_person(self) -> bool:
        """Whether the robot comes back only after the command `fleet in`."""
        return self in _NEED_PERSON

    def way_back(self, name: str) -> str:
        """Returns how the robot of this name comes back, as a sentence for people."""
        return _WAYS_BACK[self].format(name=name)


class Sign(Enum):
    """An event that begins or ends an outage."""

    REPORT = 'a report came'
    SILENCE = 'no report came for a while'
    NO_ANSWER = 'an order was not answered for a while'
    ANSWER = 'the robot takes up orders'
    CLOCK_OFF = 'the time stamps of its locations are in the future'
    CLOCK_RIGHT = 'the time stamps of its locations are right again'
    LINK_LOST = 'its computer cannot reach it'
    LINK_BACK = 'its computer reaches it, and it stands where it was expected'
    EMERGENCY = 'it reports an emergency stop'
    DRIVES = 'it drives on, or has nothing to drive'
    STANDS = 'it stands where it was stopped'
    EXCLUDED = 'by evidence it is too near to another robot'
    TAKEN = 'it goes where it was not sent'
    FAILURE = 'its route failed, or it refuses all orders'
    LEFT_GRAPH = 'it is nowhere on the graph'
    FOUND = 'it is on the graph, where it never was before'
    TAKEN_OUT = 'a person takes it out of service'
    BROUGHT_IN = 'a person brings it into service'
    DECLARED_ABSENT = 'a person says that it is not on the site'
    LOCATED = 'a location came that was taken after it was declared absent'


_NEED_PERSON: FrozenSet[Outage] = frozenset((
    Outage.TOO_NEAR, Outage.TAKEN_OVER, Outage.FAILED, Outage.OFF_GRAPH, Outage.OUT_OF_SERVICE))
_BY_ITSELF: FrozenSet[Optional[Outage]] = frozenset((
    None, *(one for one in Outage if one not in _NEED_PERSON and one is not Outage.ABSENT)))
_ON_SITE: FrozenSet[Optional[Outage]] = _BY_ITSELF | _NEED_PERSON
_ALL: FrozenSet[Optional[Outage]] = _ON_SITE | {Outage.ABSENT}


_WAYS_BACK: Mapping[Outage, str] = {
    Outage.UNSEEN: 'It comes back with its first report: switch it on, or `fleet absent {name}`.',
    Outage.ABSENT: 'It comes back when it is switched on and reports a new location.',
    Outage.SILENT: 'It comes back with its next report.',
    Outage.DEAF: 'It comes back when it answers its order, which is repeated.',
    Outage.CLOCK: 'It comes back when the clocks agree.',
    Outage.LOST_LINK: 'It comes back when its computer reaches it and it stands where expected.',
    Outage.STOPPED: 'It comes back when the emergency stop is released and the motors are on.',
    Outage.TOO_NEAR: 'When they are apart, bring it back with `fleet in {name}`.',
    Outage.TAKEN_OVER: 'When it stands on the graph, bring it back with `fleet in {name}`.',
    Outage.FAILED: 'When the cause is gone and it stands on the graph, bring it back with '
                   '`fleet in {name}`.',
    Outage.OFF_GRAPH: 'Drive it onto the graph, then bring it back with `fleet in {name}`.',
    Outage.OUT_OF_SERVICE: 'Bring it back with `fleet in {name}`.',
}


class OutageChange(NamedTuple):
    """The change that a sign makes. None stands for a robot without outage.

    sources -- the outages in which the sign has an effect
    target  -- the outage after the sign
    """

    sources: AbstractSet[Optional[Outage]]
    target: Optional[Outage]


TRANSITIONS: Mapping[Sign, OutageChange] = {
    Sign.REPORT: OutageChange({Outage.UNSEEN, Outage.SILENT}, None),
    Sign.SILENCE: OutageChange({None, Outage.STOPPED, Outage.DEAF, Outage.CLOCK}, Outage.SILENT),
    Sign.NO_ANSWER: OutageChange({None}, Outage.DEAF),
    Sign.ANSWER: OutageChange({Outage.DEAF}, None),
    Sign.CLOCK_OFF: OutageChange({None, Outage.DEAF}, Outage.CLOCK),
    Sign.CLOCK_RIGHT: OutageChange({Outage.CLOCK}, None),
    Sign.LINK_LOST: OutageChange(_BY_ITSELF, Outage.LOST_LINK),
    Sign.LINK_BACK: OutageChange({Outage.LOST_LINK}, None),
    Sign.EMERGENCY: OutageChange(_BY_ITSELF, Outage.STOPPED),
    Sign.DRIVES: OutageChange({Outage.STOPPED}, None),
    Sign.STANDS: OutageChange({Outage.STOPPED}, None),
    Sign.EXCLUDED: OutageChange(_BY_ITSELF, Outage.TOO_NEAR),
    Sign.TAKEN: OutageChange(_ON_SITE, Outage.TAKEN_OVER),
    Sign.FAILURE: OutageChange(_ON_SITE, Outage.FAILED),
    Sign.LEFT_GRAPH: OutageChange({None}, Outage.OFF_GRAPH),
    Sign.FOUND: OutageChange({Outage.OFF_GRAPH}, None),
    Sign.TAKEN_OUT: OutageChange(_ON_SITE, Outage.OUT_OF_SERVICE),
    Sign.BROUGHT_IN: OutageChange(_ON_SITE, None),
    Sign.DECLARED_ABSENT: OutageChange(_ALL, Outage.ABSENT),
    Sign.LOCATED: OutageChange({Outage.ABSENT}, None),
}
"""All transitions between outages. A sign changes nothing if no transition applies."""


_OF_REASON: Mapping[ReasonCode, Sign] = {
    ReasonCode.EMERGENCY_STOP: Sign.EMERGENCY, ReasonCode.LOST_LINK: Sign.LINK_LOST,
    ReasonCode.TAKEN_OVER: Sign.TAKEN, ReasonCode.OVERRULED: Sign.TAKEN,
    ReasonCode.CLOCK: Sign.CLOCK_OFF}


def sign_of(reason: Reason) -> Sign:
    """Returns the sign that follows from the reason of a failed or refused route."""
    return _OF_REASON.get(reason.code, Sign.FAILURE)


_OF_EPOCH: Mapping[EpochCause, Sign] = {
    EpochCause.OTHER_GIVER: Sign.TAKEN, EpochCause.CANCEL: Sign.TAKEN,
    EpochCause.OTHER_CLIENT: Sign.TAKEN, EpochCause.ROBOT: Sign.TAKEN,
    EpochCause.OTHER_MASTER: Sign.TAKEN, EpochCause.EMERGENCY_STOP: Sign.EMERGENCY,
    EpochCause.LOST_LINK: Sign.LINK_LOST}
_WORDS: Mapping[EpochCause, str] = {
    EpochCause.OTHER_GIVER: 'another program drives it',
    EpochCause.CANCEL: 'its drive was cancelled by another program',
    EpochCause.OTHER_CLIENT: 'another client of the robot drove or stopped it',
    EpochCause.ROBOT: 'the robot ended its drive by itself',
    EpochCause.OTHER_MASTER: 'it drives a route that was not given to it here',
    EpochCause.EMERGENCY_STOP: 'emergency stop',
    EpochCause.LOST_LINK: 'the link to it was lost',
    EpochCause.RESTART: 'it has forgotten its route',
    EpochCause.STOP: 'it was stopped by a command that bypassed the fleet manager'}


def sign_of_epoch(cause: EpochCause, had_route: bool) -> Optional[Sign]:
    """Returns the sign that follows from a new epoch of a robot; None: no sign follows.

    had_route -- the robot had a route, or an order for a route was on its way
    """
    if cause in (EpochCause.RESTART, EpochCause.NONE):  # NONE: a cause of a later version
        return Sign.FAILURE if had_route else None
    return _OF_EPOCH.get(cause)


def words_of(cause: EpochCause) -> str:
    """Returns a clause that says why a new epoch began."""
    return _WORDS.get(cause, 'its orders were made void')
