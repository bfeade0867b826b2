"""The master of vda5050-sdk, foreign software, gives orders to the vehicle and reads its states.

In contrast, test_vda_masters.py builds the messages of masters from their documentation.
"""
from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any, Iterator, List, Sequence, Tuple

import pytest
from vda_builders import Lab, lab
from vda_messages import ROOT

PYTHON = ROOT / 'build' / 'vda5050_master' / 'bin' / 'python'
PROGRAM = Path(__file__).with_name('foreign_master.py')
WAY = (8, 10, 12, 14)


def places(vertices: Sequence[int]) -> List[Tuple[str, float, float]]:
    return [(str(vertex), *lab().vertex(vertex).position) for vertex in vertices]


class Pair:
    """The vehicle and its foreign master. All states of the vehicle reach the master."""

    def __init__(self, master: subprocess.Popen) -> None:
        self.vehicle = Lab()
        self._master = master
        self._told = 0

    def ask(self, name: str, *arguments: Any) -> List[str]:
        """Lets the master act, and gives its messages to the vehicle.

        Returns the errors that the master found.
        """
        assert self._master.stdin and self._master.stdout
        print(json.dumps([name, *arguments]), file=self._master.stdin, flush=True)
        sent, wrong = json.loads(self._master.stdout.readline())
        for topic, message in sent:
            self.vehicle.do(self.vehicle.vehicle.receive(
                [(topic.rsplit('/', 1)[-1], message.encode())], self.vehicle.now))
        return wrong

    def tell(self) -> List[str]:
        """Gives the new states of the vehicle to the master.

        Returns the errors that the master found.
        """
        new, self._told = self.vehicle.states[self._told:], len(self.vehicle.states)
        return [wrong for state in new for wrong in self.ask('receive', 'state', state)]

    def do(self, name: str, *arguments: Any) -> None:
        assert self.ask(name, *arguments) == []
        assert self.tell() == []

    def drive(self) -> None:
        self.vehicle.drive(1)
        assert self.tell() == []


@pytest.fixture
def pair() -> Iterator[Pair]:
    if not PYTHON.exists():
        pytest.skip('vda5050-sdk is not in build/vda5050_master: scripts/test.sh installs it from '
                    'PyPI, for Python 3.10 or later')
    with subprocess.Popen([PYTHON, '-I', PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          universal_newlines=True) as master:
        yield Pair(master)
        assert master.stdin
        master.stdin.close()


@pytest.mark.parametrize('released', [1, 2, 3])
def test_its_order_is_driven_as_far_as_it_releases_it(pair, released):
    pair.do('order', 'o', places(WAY), released, 0)
    pair.vehicle.end_action('say-8')
    for _ in range(released - 1):
        pair.drive()
    assert not pair.vehicle.robot.drives
    pair.do('extend', places(WAY[released - 1:]))
    assert pair.vehicle.state['orderUpdateId'] == 1
    for _ in range(len(WAY) - released):
        pair.drive()
    assert (pair.vehicle.nodes, pair.vehicle.state['lastNodeId']) == ([], '14')


def test_it_pauses_and_resumes_again_and_again(pair):
    """All pauses have one actionId, and all resumptions have another. The vehicle obeys, but
    reports an error.
    """
    pair.do('order', 'o', places(WAY), len(WAY), None)
    for act, is_paused in 2 * [('pause', True), ('resume', False)]:
        assert pair.ask('act', act) == []
        pair.vehicle.settle()
        assert all('instantActionError' in complaint for complaint in pair.tell())
        assert (pair.vehicle.state['paused'], pair.vehicle.robot.drives) == (
            is_paused, not is_paused)


def test_it_cancels_its_order_and_gives_the_next(pair):
    pair.do('order', 'o', places(WAY), len(WAY), None)
    pair.drive()
    pair.do('act', 'cancel_order')
    pair.vehicle.settle()
    assert pair.tell() == []
    assert (pair.vehicle.status('cancel-order'), pair.vehicle.nodes) == ('FINISHED', [])
    pair.do('order', 'next', places(WAY[1:]), len(WAY) - 1, None)
    pair.drive()
    assert pair.vehicle.state['lastNodeId'] == '12'


def test_each_request_of_a_state_is_answered(pair):
    for _ in range(2):
        before = len(pair.vehicle.states)
        assert pair.ask('act', 'request_state') == []
        assert len(pair.vehicle.states) > before
        assert pair.vehicle.status('state-request') == 'FINISHED'


def test_it_reads_why_its_order_is_refused(pair):
    assert pair.ask('order', 'far', places(WAY[2:]), 2, None) == []
    complaints = pair.tell()
    assert len(complaints) == 1, complaints
    assert 'far' in complaints[0]
