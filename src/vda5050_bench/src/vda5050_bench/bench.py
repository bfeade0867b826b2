"""Tests a VDA 5050 vehicle and prints a scorecard, one line per rule of the standard.

The vehicle must stand on the track. Before each rule the bench cancels the vehicle's order and
drives the vehicle to an end of the track. A vehicle that breaks a rule of level MUST gets the
outcome BROKEN. If a vehicle does not follow a recommendation (SHOULD), or a rule that only follows
from the standard (DERIVED), the outcome is "not followed". It does not change the exit status.
"""
from __future__ import annotations

import argparse
import json
import sys
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from typing import Iterator, Optional, Sequence

from vda5050_bench.layout import track_over
from vda5050_bench.master import BenchMaster, TooLate
from vda5050_bench.rules import BenchRule, Broken, NotTried, RuleLevel, Start, rules_of
from vda5050_bench.track import read_track
from vda5050_bench.trial import SlowAction, Trial
from vda5050_mqtt.credentials import WrongCredentials, read_credentials
from vda5050_mqtt.link import Broker
from vda5050_mqtt.own_broker import OwnBroker

# Exceptions that malformed messages cause; OSError if the broker is not reachable.
_MALFORMED = (AttributeError, IndexError, KeyError, TypeError, ValueError, OSError)

DIED = 'the vehicle has died: its last will came, CONNECTIONBROKEN'


class RuleOutcome(Enum):
    """The outcome of a rule."""

    PASSED = 'passed'
    BROKEN = 'BROKEN'
    NOT_FOLLOWED = 'not followed'
    NOT_TRIED = 'not tried'


@dataclass(frozen=True)
class Verdict:
    """The outcome of a rule, and the reason."""

    rule: BenchRule
    outcome: RuleOutcome
    text: str = ''


class Bench:
    """One run over all rules."""

    def __init__(self, trial: Trial, version: str) -> None:
        self.trial = trial
        self._rules = rules_of(version)
        # number of states that came before the silence; None: no silence
        self._silent_since: Optional[int] = None

    def run(self) -> Iterator[Verdict]:
        """Tries every rule, then drives the vehicle to the start of the track if possible."""
        for rule in self._rules:
            yield self._verdict(rule)
        if self._is_there():
            with suppress(TooLate, NotTried, *_MALFORMED):
                self.trial.bring_home()

    def _verdict(self, rule: BenchRule) -> Verdict:
        if rule.start is not Start.NOTHING and not self._is_there():
            return Verdict(rule, RuleOutcome.NOT_TRIED, self._silence())
        deaths = len(self.trial.deaths)
        try:
            self._prepare(rule.start)
            rule.attempt(self.trial)
        except NotTried as reason:
            return Verdict(rule, RuleOutcome.NOT_TRIED, str(reason))
        except (Broken, TooLate) as problem:
            has_died = len(self.trial.deaths) > deaths
            is_silent = isinstance(problem, TooLate) and self._falls_silent(rule.start)
            if rule.start is not Start.NOTHING and (has_died or is_silent):
                return Verdict(rule, RuleOutcome.NOT_TRIED, DIED if has_died else self._silence())
            return Verdict(rule, RuleOutcome.BROKEN if rule.level is RuleLevel.MUST
                           else RuleOutcome.NOT_FOLLOWED, str(problem))
        except _MALFORMED as error:
            return Verdict(rule, RuleOutcome.NOT_TRIED,
                           f'the messages for this rule cannot be read: {error!r}')
        return Verdict(rule, RuleOutcome.PASSED)

    def _prepare(self, start: Start) -> None:
        if start is Start.NOTHING:
            return
        try:
            self.trial.bring_back()
        except (TooLate, NotTried) as reason:
            if isinstance(reason, TooLate) and self._falls_silent(start):
                raise NotTried(self._silence()) from None
            if start is Start.AT_END:
                raise NotTried(f'the vehicle cannot be brought back: {reason}') from None

    def _falls_silent(self, start: Start) -> bool:
        """Returns whether no state comes any more; a vehicle that has died may start again."""
        if start is Start.NOTHING:
            return False
        before = self.trial.master.count()
        try:
            self.trial.fetch()
        except TooLate:
            if not self.trial.is_dead or not self.trial.comes_back(before):
                self._silent_since = before
            return True
        return False

    def _is_there(self) -> bool:
        """Returns whether states come; no rule waits for a vehicle that is silent."""
        if self._silent_since is not None and self.trial.master.count() > self._silent_since:
            self._silent_since = None
        return self._silent_since is None

    def _silence(self) -> str:
        return DIED if self.trial.is_dead else 'the vehicle is silent'


def line(verdict: Verdict) -> str:
    """Returns the line of a verdict; a second line says what the bench has observed."""
    rule = verdict.rule
    return (f'{verdict.outcome.value:12}  {rule.level.value:6}  {rule.section:22}  '
            f'{rule.sentence}' + (f'\n{"":14}{verdict.text}' if verdict.text else ''))


def total(verdicts: Sequence[Verdict]) -> str:
    """Returns the last line of the scorecard."""
    return ', '.join(f'{sum(verdict.outcome is outcome for verdict in verdicts)} {outcome.value}'
                     for outcome in RuleOutcome)


def scorecard(verdicts: Sequence[Verdict]) -> str:
    """Returns the scorecard: one line per rule, and the last line."""
    return '\n'.join([*map(line, verdicts), total(verdicts)])


def read_slow_action(text: str) -> Optional[SlowAction]:
    """Parses an action with parameters, e.g. `noop duration=5`; raises ValueError."""
    if not text:
        return None
    kind, *parameters = text.split()
    found = {}
    for parameter in parameters:
        key, sign, value = parameter.partition('=')
        if not sign:
            raise ValueError(f'--slow-action: {parameter!r} is not KEY=VALUE')
        try:
            found[key] = json.loads(value)
        except ValueError:
            found[key] = value
    return SlowAction(kind, found)


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Runs the program; returns 0: no rule was broken, 1: a rule was broken, 2: not tested."""
    parser = argparse.ArgumentParser(prog='vda5050_bench', description=__doc__)
    parser.add_argument('--broker', default='127.0.0.1:1883', help='host:port')
    parser.add_argument('--own-broker', action='store_true',
                        help='start a mosquitto on the port of --broker on this computer, and '
                             'kill it during the test; the vehicle must connect to it')
    parser.add_argument('--credentials-file', default='', help='YAML with username and password')
    parser.add_argument('--ca-file', default='', help='PEM file; switches TLS on')
    parser.add_argument('--interface', default='uagv', help='first level of the topics')
    parser.add_argument('--manufacturer', required=True)
    parser.add_argument('--serial', required=True)
    parser.add_argument('--version', default='2.1.0', help='version of the standard')
    parser.add_argument('--track', help='file with an order in JSON that has three nodes or more')
    parser.add_argument('--graph', help='trajectory graph (YAML), instead of --track')
    parser.add_argument('--vertices', type=int, nargs='+',
                        help='vertices of the graph over which the track leads')
    parser.add_argument('--map-id', default='map', help='mapId of a track from a graph')
    parser.add_argument('--actions-key', default='actions',
                        help='JSON key of the list in instantActions; drafts of 2.0 use '
                             'instantActions')
    parser.add_argument('--slow-action', default='', metavar='"TYPE KEY=VALUE ..."',
                        help='a harmless action of the vehicle that takes 5 s or more, and that '
                             'is allowed at nodes and as an instant action')
    parser.add_argument('--patience', type=float, default=60.0,
                        help='s that the vehicle may take for a part of the track')
    options = parser.parse_args(arguments)
    try:
        slow = read_slow_action(options.slow_action)
        track = (read_track(options.track) if options.track
                 else track_over(options.graph, options.vertices or (), options.map_id))
        host, _, port = options.broker.rpartition(':')
        broker = Broker(host, int(port), *read_credentials(options.credentials_file),
                        ca_file=options.ca_file)
    except (OSError, ValueError, WrongCredentials) as error:
        parser.error(str(error))
    if len(track.stops) < 3:
        parser.error('the track needs three nodes or more')
    own_broker = OwnBroker(broker.port) if options.own_broker else None
    major = 'v' + options.version.split('.')[0]
    prefix = f'{options.interface}/{major}/{options.manufacturer}/{options.serial}'
    master = BenchMaster(broker, prefix, options.version, actions_key=options.actions_key)
    trial = Trial(master, track, options.patience, own_broker, slow)
    verdicts = []
    try:
        for verdict in tried(trial, options.version):
            verdicts.append(verdict)
            print(line(verdict), flush=True)
    except TooLate as error:
        print(f'The vehicle cannot be tested: {error}', file=sys.stderr)
        return 2
    finally:
        trial.close()
        if own_broker:
            own_broker.close()
    for remark in trial.master.checker.remarks:
        print(f'remark        {remark}')
    print(total(verdicts))
    return int(any(verdict.outcome is RuleOutcome.BROKEN for verdict in verdicts))


def tried(trial: Trial, version: str) -> Iterator[Verdict]:
    """Waits for the vehicle, then tries every rule; raises TooLate if no state comes."""
    trial.master.wait(lambda s: True, 35.0, 'a state of the vehicle', after=0)
    return Bench(trial, version).run()
