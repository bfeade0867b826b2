"""Tries a VDA 5050 vehicle and prints a scorecard, one line per rule of the standard.

The vehicle must stand at the first node of the track, without an order. It is driven there and
back.
"""
from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Callable, List, Optional, Sequence

from vda5050_vehicle.conformance.layout import track_over
from vda5050_vehicle.conformance.master import Master, Message, TooLate
from vda5050_vehicle.conformance.rules import QUIET, RULES, Broken, NotTried, Rule
from vda5050_vehicle.conformance.track import Track, read_track
from vda5050_vehicle.mqtt.credentials import WrongCredentials, read_credentials
from vda5050_vehicle.mqtt.embedded_broker import configuration, find_mosquitto
from vda5050_vehicle.mqtt.link import Broker, make_client, secure

PASSED, BROKEN, NOT_TRIED = 'passed', 'BROKEN', 'not tried'
AWAY = 2.0  # s for which the broker is lost


@dataclass(frozen=True)
class Verdict:
    """What came of a rule."""

    rule: Rule
    outcome: str
    text: str = ''


@dataclass(frozen=True)
class Loss:
    """What came of a broker's death."""

    back_after: float
    drove_on: bool


class OwnBroker:
    """A mosquitto that the bench may kill and start again."""

    def __init__(self, port: int) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._file = Path(self._folder.name) / 'mosquitto.conf'
        Path(self._folder.name).chmod(0o755)
        self._file.write_text(configuration(port))
        self.start()

    def start(self) -> None:
        """Starts it."""
        self._process = subprocess.Popen([find_mosquitto(), '-c', str(self._file)],
                                         stderr=subprocess.DEVNULL)

    def kill(self) -> None:
        """As if the power had failed."""
        self._process.kill()
        self._process.wait()

    def close(self) -> None:
        """Ends it for good."""
        self.kill()
        self._folder.cleanup()


class Bench:
    """One run over the rules, and what they share.

    there     -- the track, from where the vehicle stands
    half      -- index of the node that is the first decision point
    at        -- index on the way back at which the vehicle is
    patience  -- s that driving from node to node may take
    """

    def __init__(self, broker: Broker, prefix: str, track: Track, version: str, patience: float,
                 own_broker: Optional[OwnBroker] = None,
                 master: Optional[Master] = None) -> None:
        self.master = master or Master(broker, prefix, version)
        self.there = track
        self.half = len(track.stops) // 2
        self.patience = patience
        self.at = 0
        self.order_id = ''
        self.loss: Optional[Loss] = None
        self._broker = broker
        self._own_broker = own_broker

    def run(self) -> List[Verdict]:
        """Tries every rule; after three in a row that came too late the others are not tried."""
        verdicts: List[Verdict] = []
        late = 0
        for rule in RULES:
            if late >= 3:
                verdicts.append(Verdict(rule, NOT_TRIED, 'the vehicle does not go on'))
                continue
            try:
                rule.attempt(self)
                verdicts.append(Verdict(rule, PASSED))
                late = 0
            except NotTried as reason:
                verdicts.append(Verdict(rule, NOT_TRIED, str(reason)))
            except Broken as problem:
                verdicts.append(Verdict(rule, BROKEN, str(problem)))
            except (TooLate, KeyError, ValueError) as problem:
                late += 1
                verdicts.append(Verdict(rule, BROKEN, str(problem)))
        return verdicts

    def new_id(self) -> str:
        """An id that was not used before."""
        return uuid.uuid4().hex[:12]

    def stays(self, after: int, predicate: Callable[[Message], bool], what: str) -> None:
        """Every state of the next second is so, and one comes on request."""
        deadline = time.monotonic() + QUIET
        while time.monotonic() < deadline:
            for state in self.master.messages['state'][after:]:
                if not predicate(state):
                    raise Broken(f'it does not stay so: {what}')
            time.sleep(0.05)
        self.master.ended(self.master.act('stateRequest'))
        if not predicate(self.master.state):
            raise Broken(f'it does not stay so: {what}')

    def is_retained(self, topic: str) -> bool:
        """Whether somebody who comes now gets the last message on a topic."""
        got = threading.Event()
        client = make_client(f'late_{uuid.uuid4().hex[:12]}')
        client.on_connect = lambda *_: client.subscribe(f'{self.master.prefix}/{topic}')
        client.on_message = lambda *_: got.set()
        secure(client, self._broker)
        client.connect(self._broker.host, self._broker.port)
        client.loop_start()
        found = got.wait(2.0)
        client.disconnect()
        client.loop_stop()
        return found

    def lose_broker_meanwhile(self) -> None:
        """While the vehicle drives: the broker dies, and comes back."""
        if self._own_broker is None:
            return
        master = self.master
        master.wait(lambda s: s['driving'], self.patience, 'driving')
        before, online = master.state, master.count('connection')
        states = master.count()
        self._own_broker.kill()
        master.checker.broker_lost()
        time.sleep(AWAY)
        self._own_broker.start()
        back = time.monotonic()
        master.wait(lambda m: m['connectionState'] == 'ONLINE', 15.0, 'ONLINE', 'connection',
                    online)
        self.loss = Loss(time.monotonic() - back, False)
        after = master.wait(lambda s: True, 5.0, 'a fresh state', after=states)
        drove_on = (after['lastNodeSequenceId'] > before['lastNodeSequenceId']
                    or after.get('agvPosition') != before.get('agvPosition'))
        self.loss = Loss(self.loss.back_after, drove_on)

    def close(self) -> None:
        """Leaves the vehicle."""
        self.master.close()


def scorecard(verdicts: Sequence[Verdict]) -> str:
    """One line per rule."""
    width = max(len(verdict.rule.title) for verdict in verdicts)
    lines = [f'{verdict.outcome:9}  {verdict.rule.title:{width}}  {verdict.rule.section}'
             + (f'\n           {verdict.text}' if verdict.text else '') for verdict in verdicts]
    counts = {outcome: sum(verdict.outcome == outcome for verdict in verdicts)
              for outcome in (PASSED, BROKEN, NOT_TRIED)}
    return '\n'.join([*lines, ', '.join(f'{n} {outcome}' for outcome, n in counts.items())])


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """The program; returns 0 where no rule was broken, 1 where one was, 2 on wrong arguments."""
    parser = argparse.ArgumentParser(prog='vda5050_bench', description=__doc__)
    parser.add_argument('--broker', default='127.0.0.1:1883', help='host:port')
    parser.add_argument('--own-broker', action='store_true',
                        help='start a mosquitto on that port of this computer, and kill it under '
                             'way; the vehicle must connect to it')
    parser.add_argument('--credentials-file', default='', help='YAML with username and password')
    parser.add_argument('--ca-file', default='', help='PEM; with it the connection is TLS')
    parser.add_argument('--interface', default='uagv', help='first level of the topics')
    parser.add_argument('--manufacturer', required=True)
    parser.add_argument('--serial', required=True)
    parser.add_argument('--version', default='2.1.0', help='of the standard')
    parser.add_argument('--track', help='file with an order in JSON: four nodes or more')
    parser.add_argument('--graph', help='trajectory graph (YAML), in place of --track')
    parser.add_argument('--vertices', type=int, nargs='+', help='of the graph, the track')
    parser.add_argument('--map-id', default='map', help='mapId of the track made of a graph')
    parser.add_argument('--patience', type=float, default=60.0,
                        help='s that the vehicle may take for a part of the track')
    options = parser.parse_args(arguments)
    try:
        track = (read_track(options.track) if options.track
                 else track_over(options.graph, options.vertices or (), options.map_id))
        host, _, port = options.broker.rpartition(':')
        broker = Broker(host, int(port), *read_credentials(options.credentials_file),
                        ca_file=options.ca_file)
    except (OSError, ValueError, WrongCredentials) as error:
        parser.error(str(error))
    if len(track.stops) < 4:
        parser.error('the track needs four nodes or more')
    own_broker = OwnBroker(broker.port) if options.own_broker else None
    major = 'v' + options.version.split('.')[0]
    bench = Bench(broker, f'{options.interface}/{major}/{options.manufacturer}/{options.serial}',
                  track, options.version, options.patience, own_broker)
    try:
        bench.master.wait(lambda s: not [e for e in s['errors'] if e['errorLevel'] == 'FATAL'],
                          35.0, 'a state of the vehicle without a FATAL error')
        verdicts = bench.run()
    except TooLate as error:
        print(f'The vehicle cannot be tried: {error}', file=sys.stderr)
        return 2
    finally:
        bench.close()
        if own_broker:
            own_broker.close()
    print(scorecard(verdicts))
    return int(any(verdict.outcome == BROKEN for verdict in verdicts))
