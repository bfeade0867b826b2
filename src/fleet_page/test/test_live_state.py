"""The server knows the revision that a client has, and sends only newer entries."""
import json

from hypothesis import given
from hypothesis import strategies as st

from fleet_page.core import live_state
from fleet_page.core.layers import ALLOCATION, PLAN, ShownLayers
from fleet_page.core.live_state import LiveState

KEYS = st.sampled_from('abcde')
STEPS = st.lists(st.one_of(st.tuples(st.just('put'), KEYS, st.integers(0, 2)),
                           st.tuples(st.just('remove'), KEYS), st.tuples(st.just('read'))))


class Client:
    def __init__(self):
        self.seen, self.known = 0, {}

    def read(self, live):
        update = json.loads(live.update(self.seen) or live.nothing_new())
        if update['full']:
            self.known = {}
        for key in update['gone']:
            self.known.pop(key, None)
        self.known.update(update['set'])
        self.seen = update['revision']
        return update


@given(STEPS)
def test_a_client_that_reads_whenever_it_likes_knows_what_is_newest(steps):
    live, client, truth = LiveState(), Client(), {}
    for step in steps:
        if step[0] == 'put':
            live.put(step[1], step[2])
            truth[step[1]] = step[2]
        elif step[0] == 'remove':
            live.remove(step[1])
            truth.pop(step[1], None)
        else:
            client.read(live)
            assert client.known == truth
    client.read(live)
    assert client.known == truth


KEYS_OF_LAYERS = st.sampled_from(('a', 'plan:a', 'allocation:a', 'laser:a', 'laser:b'))
SHOWN = st.builds(ShownLayers, st.frozensets(st.sampled_from((PLAN, ALLOCATION))),
                  st.sampled_from(('', 'a', 'b')))


@given(SHOWN, st.lists(st.tuples(st.booleans(), KEYS_OF_LAYERS, st.integers(0, 1))))
def test_a_client_gets_the_entries_of_the_layers_that_it_shows_and_nothing_for_others(
        layers, steps):
    live, known = LiveState(), {}
    seen = json.loads(live.update(0, layers))['revision']
    for is_put, key, value in steps:
        before = dict(known)
        if is_put:
            live.put(key, value)
        else:
            live.remove(key)
        text = live.update(seen, layers)
        for gone in json.loads(text)['gone'] if text else ():
            known.pop(gone, None)
        known.update(json.loads(text)['set'] if text else {})
        seen = live.revision
        truth = {one: live.get(one) for one in ('a', 'plan:a', 'allocation:a', 'laser:a', 'laser:b')
                 if live.get(one) is not None and layers.shows(one)}
        assert known == truth and bool(text) >= (known != before)
        assert layers.shows(key) or not text


def test_only_what_a_client_shows_must_be_received():
    assert ShownLayers(frozenset((PLAN,))).sources == frozenset()
    assert ShownLayers(frozenset((ALLOCATION,)), 'a').sources == {'allocation', 'laser:a'}


def test_the_same_value_again_is_no_change():
    live = LiveState()
    live.put('a', [1])
    before = live.revision
    live.put('a', [1])
    live.remove('b')
    assert live.revision == before


def test_a_client_that_lags_gets_the_newest_value_only():
    live, client = LiveState(), Client()
    live.put('a', 0)
    client.read(live)
    for value in range(1000):
        live.put('a', value)
    assert client.read(live)['set'] == {'a': 999}


def test_a_client_that_missed_forgotten_removals_gets_everything(monkeypatch):
    monkeypatch.setattr(live_state, 'MOST_GONE', 2)
    live, client = LiveState(), Client()
    for key in 'abcd':
        live.put(key, 1)
    client.read(live)
    for key in 'abc':
        live.remove(key)
    assert client.read(live)['full'] and client.known == {'d': 1}


def test_a_client_of_another_server_gets_everything():
    live = LiveState()
    live.put('a', 1)
    assert json.loads(live.update(10 ** 6))['full']


def test_replacing_a_group_leaves_others_alone():
    live = LiveState()
    live.put('robot:a', 1)
    live.put('pose:a', 1)
    live.replace('robot:', {'b': 2})
    assert live.entries('robot:') == {'b': 2} and live.get('pose:a') == 1
