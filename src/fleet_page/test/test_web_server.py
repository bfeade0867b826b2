"""The page over HTTP: permissions, hostile requests, and event streams that cost little."""
from __future__ import annotations

import asyncio
import json
import threading

import pytest

pytest.importorskip('aiohttp')

from aiohttp import ClientSession, CookieJar, TCPConnector  # noqa: E402
from page_builders import (  # noqa: E402
    TOKENS,
    ServedSite,
    no_missions,
    show_fleet,
    until,
)
from yarl import URL  # noqa: E402

from fleet_core.supervision.journal_database import JournalError  # noqa: E402
from fleet_page.core.acts import RULES, ActKind  # noqa: E402
from fleet_page.core.page import NAMED  # noqa: E402
from fleet_page.core.rate_limits import RateLimit  # noqa: E402
from fleet_page.core.roles import UserRole  # noqa: E402
from fleet_page.door import door as door_module  # noqa: E402
from fleet_page.door import worker as worker_module  # noqa: E402

ROUTES = ('/', '/page/main.js', '/chart.js', '/api/me', '/api/events', '/api/site', '/api/map.png',
          '/api/history', '/api/history.csv', '/api/replay', '/api/robot?name=a', '/api/audit',
          '/metrics')
NEED_LOGIN = ROUTES[4:]
CONTENT = {'destinations': [2], 'mission': 7, 'priority': 1, 'edges': [1], 'robot': 'a',
           'name': 'tour', 'answer': 'retry', 'step': '5',
           'arguments': {'to': '39'}}


def body_of(kind: ActKind) -> dict:
    return {'act': kind.value, **{name: CONTENT[name] for name in RULES[kind].needed}}


class Client:
    """One browser, with cookies of its own."""

    def __init__(self, session: ClientSession, port: int) -> None:
        self.session = session
        self.origin = f'http://127.0.0.1:{port}'

    def url(self, path: str) -> str:
        return self.origin + path

    def get(self, path: str, **more):
        return self.session.get(self.url(path), **more)

    def post(self, path: str, content, **more):
        headers = {'Origin': self.origin, **more.pop('headers', {})}
        return self.session.post(self.url(path), json=content, headers=headers,
                                  **more)

    async def act(self, content, **more):
        async with self.post('/api/act', content, **more) as answer:
            return answer.status, await answer.json()

    async def login(self, role: str) -> int:
        async with self.post('/api/login', {'token': TOKENS[role]}) as answer:
            return answer.status


def served(folder, test, secured: bool = False, journal=no_missions, **more) -> None:
    """Runs test(site, client, new_client) with a page on a free port."""
    async def work() -> None:
        site = ServedSite(folder, secured, journal, **more)
        show_fleet(site.page)
        sessions = []
        await site.open()

        def new_client(address: str = '127.0.0.1') -> Client:
            # Without `unsafe`, the jar does not keep cookies of a bare IP address.
            sessions.append(ClientSession(cookie_jar=CookieJar(unsafe=True),
                                          connector=TCPConnector(local_addr=(address, 0))))
            return Client(sessions[-1], site.port)
        try:
            await test(site, new_client(), new_client)
        finally:
            for session in sessions:
                await session.close()
            await site.close()
    asyncio.run(work())


def test_every_route_has_the_headers_that_keep_others_out(tmp_path):
    async def test(_site, client, _new):
        for path in ROUTES:
            async with client.get(path) as answer:
                policy = answer.headers['Content-Security-Policy']
                assert "default-src 'none'" in policy and 'unsafe' not in policy, path
                assert answer.headers['X-Content-Type-Options'] == 'nosniff'
                assert answer.headers['Referrer-Policy'] == 'no-referrer'
                if path != '/api/events':
                    await answer.read()
    served(tmp_path, test)


def test_a_client_gets_everything_and_then_what_changed(tmp_path):
    async def test(site, client, _new):
        async with client.get('/api/events') as answer:
            assert answer.content_type == 'text/event-stream'
            first = await event(answer)
            assert first['full'] and first['set']['robot:b']['waits_for'] == 'wheel blocked'
            site.page.model.close_edges([3])
            second = await event(answer)
            assert not second['full'] and second['set'] == {'closed': [3]}
    served(tmp_path, test)


async def event(answer) -> dict:
    while True:
        line = await asyncio.wait_for(answer.content.readline(), 5.0)
        if line.startswith(b'data: '):
            return json.loads(line[6:])


async def event_id(answer) -> str:
    while True:
        line = await asyncio.wait_for(answer.content.readline(), 5.0)
        if line.startswith(b'id: '):
            return line[4:].decode().strip()


def test_a_client_that_comes_again_gets_only_what_it_missed_of_this_server(tmp_path):
    async def test(site, client, _new):
        async with client.get('/api/events') as answer:
            last = await event_id(answer)
        site.page.model.close_edges([3])
        for wanted, headers in ((False, {'Last-Event-ID': last}),
                                (True, {'Last-Event-ID': 'other-5'}),
                                (True, {'Last-Event-ID': f'{last}x'}),
                                (True, {'Last-Event-ID': '\u0664'.encode().decode('latin1')})):
            async with client.get('/api/events', headers=headers) as answer:
                assert (await event(answer))['full'] is wanted
    served(tmp_path, test)


def test_a_client_that_reads_nothing_delays_no_other_and_is_let_go(tmp_path, monkeypatch):
    monkeypatch.setattr(worker_module, 'STALLED', 0.5)

    async def test(site, client, new_client):
        reader, writer = await asyncio.open_connection(
            '127.0.0.1', int(client.origin.rpartition(':')[2]), limit=1)
        writer.transport.pause_reading()
        host = client.origin.partition('//')[2]
        writer.write(f'GET /api/events HTTP/1.1\r\nHost: {host}\r\n\r\n'.encode())
        await until(lambda: site.web.clients == 1)
        async with new_client().get('/api/events') as answer:
            await event(answer)
            for number in range(60):
                site.page.model.live.put('big', f'{number}' + 'x' * 100_000)
                assert 'big' in (await event(answer))['set']
            await until(lambda: site.web.clients == 1)
        writer.close()
        del reader
    served(tmp_path, test)


def test_loopback_needs_no_login_and_every_act_reaches_the_fleet(tmp_path):
    async def test(site, client, _new):
        for kind in ActKind:
            status, answer = await client.act(body_of(kind))
            assert status == 200, (kind, answer)
        own = {*NAMED, ActKind.ACKNOWLEDGE}
        assert site.fleet.kinds == [kind for kind in ActKind if kind not in own]
        acts = [row['act'] for row in site.page.records.audit(100)]
        assert sorted(acts) == sorted(kind.value for kind in ActKind)
    served(tmp_path, test)


@pytest.mark.parametrize('role', TOKENS)
def test_a_role_may_do_what_the_table_says(tmp_path, role):
    async def test(site, client, _new):
        assert await client.login(role) == 200
        for kind in ActKind:
            allowed = RULES[kind].role <= UserRole[role.upper()]
            status, answer = await client.act(body_of(kind))
            assert (status == 200) is allowed, (kind, answer)
            assert status in (200, 403)
        for path in ('/api/site', '/api/history', '/api/replay', '/api/robot?name=a', '/metrics'):
            async with client.get(path) as answer:
                assert answer.status == 200
        async with client.get('/api/audit') as answer:
            assert answer.status == (403 if role == 'see' else 200)
    served(tmp_path, test, secured=True)


def test_without_a_login_nothing_is_shown_and_nothing_done(tmp_path):
    async def test(site, client, _new):
        for path in NEED_LOGIN:
            async with client.get(path) as answer:
                assert answer.status == 401, path
        for kind in ActKind:
            assert (await client.act(body_of(kind)))[0] == 401
        async with client.get('/api/me') as answer:
            assert await answer.json() == {'name': None, 'role': None, 'login': True}
        assert site.fleet.acts == []
    served(tmp_path, test, secured=True)


def test_the_cookie_is_out_of_reach_for_scripts_and_other_sites(tmp_path):
    async def test(_site, client, _new):
        async with client.post('/api/login', {'token': TOKENS['see']}) as answer:
            cookie = answer.headers['Set-Cookie']
            assert 'HttpOnly' in cookie and 'SameSite=Strict' in cookie
            assert TOKENS['see'] not in cookie and 'Max-Age' not in cookie
        async with client.post('/api/logout', {}):
            pass
        async with client.get('/api/site') as answer:
            assert answer.status == 401
    served(tmp_path, test, secured=True)


def test_a_logout_ends_a_stream_that_is_open(tmp_path):
    async def test(site, client, _new):
        await client.login('see')
        async with client.get('/api/events') as answer:
            await event(answer)
            async with client.post('/api/logout', {}):
                pass
            await until(lambda: site.web.clients == 0)
    served(tmp_path, test, secured=True)


def test_tokens_cannot_be_guessed_quickly(tmp_path):
    async def test(_site, client, _new):
        seen = []
        for number in range(10):
            token = f'wrong-{number}-wrong-wrong'
            async with client.post('/api/login', {'token': token}) as answer:
                seen.append(answer.status)
        assert seen[0] == 401 and seen[-1] == 429
    served(tmp_path, test, secured=True)


def test_a_monitor_shows_its_token_in_a_header(tmp_path):
    async def test(_site, client, _new):
        for token, status in ((TOKENS['see'], 200), ('wrong', 401)):
            headers = {'Authorization': f'Bearer {token}'}
            async with client.get('/metrics', headers=headers) as answer:
                assert answer.status == status
    served(tmp_path, test, secured=True)


def test_a_valid_token_is_let_in_however_many_were_wrong(tmp_path):
    async def test(_site, client, new_client):
        for number in range(60):
            async with client.post('/api/login', {'token': f'wrong-{number}-wrong-wrong'}):
                pass
            headers = {'Authorization': f'Bearer wrong-{number}'}
            async with client.get('/metrics', headers=headers) as answer:
                assert answer.status in (401, 429)
        assert await client.login('operate') == 200
        assert await new_client('127.0.0.2').login('see') == 200
        for address in ('127.0.0.1', '127.0.0.2'):
            headers = {'Authorization': f'Bearer {TOKENS["see"]}'}
            async with new_client(address).get('/metrics', headers=headers) as answer:
                assert answer.status == 200
    served(tmp_path, test, secured=True)


def test_a_token_that_is_revoked_ends_its_sessions_and_streams_at_once(tmp_path):
    async def test(site, client, new_client):
        await client.login('operate')
        other = new_client()
        await other.login('see')
        async with client.get('/api/events') as stream:
            await event(stream)
            (tmp_path / 'tokens').write_text(f'see seer {TOKENS["see"]}\n')
            await until(lambda: site.web.clients == 0)
        assert (await client.act({'act': 'stop'}))[0] == 401
        async with other.get('/api/site') as answer:
            assert answer.status == 200
        assert site.fleet.acts == []
    served(tmp_path, test, secured=True)


def test_one_who_only_sees_cannot_take_all_streams(tmp_path):
    async def test(site, client, new_client):
        await client.login('see')
        held, refused = [], 0
        for number in range(70):
            other = new_client(f'127.0.1.{number + 1}')
            other.session.cookie_jar.update_cookies(client.session.cookie_jar.filter_cookies(
                URL(client.origin)), URL(client.origin))
            answer = await other.get('/api/events')
            held.append(answer)
            refused += answer.status == 503
        assert refused == 30 and site.web.clients == 40
        operator = new_client('127.0.2.1')
        await operator.login('operate')
        async with operator.get('/api/events') as answer:
            assert answer.status == 200
        assert (await operator.act({'act': 'stop'}))[0] == 200
        for answer in held:
            answer.close()
    served(tmp_path, test, secured=True)


def test_a_flood_of_views_with_one_token_is_held_back_whatever_its_addresses(tmp_path, monkeypatch):
    monkeypatch.setattr(door_module, 'HELD_BACK', 0.01)

    async def test(site, client, new_client):
        site.door._of_persons = RateLimit(60.0, 0.0)
        await client.login('see')
        seen = []
        for number in range(40):
            other = new_client(f'127.0.1.{number + 1}')
            other.session.cookie_jar.update_cookies(client.session.cookie_jar.filter_cookies(
                URL(client.origin)), URL(client.origin))
            for _ in range(3):
                async with other.get('/api/me') as answer:
                    seen.append(answer.status)
        assert seen == [200] * 60 + [429] * 60
        operator = new_client()
        await operator.login('operate')
        async with operator.get('/api/site') as answer:
            assert answer.status == 200
    served(tmp_path, test, secured=True)


def test_a_stay_of_401_digits_is_refused_in_words(tmp_path):
    async def test(site, client, _new):
        status, answer = await client.act(
            {'act': 'send', 'destinations': [1], 'stays': [10 ** 400]})
        assert status == 400 and 'stays must be numbers' in answer['text']
        assert site.fleet.acts == []
    served(tmp_path, test)


@pytest.mark.parametrize('headers', [
    {'Origin': 'http://evil.example'}, {'Origin': 'null'}, {'Origin': ''},
    {'Origin': 'https://127.0.0.1'}])
def test_a_post_of_another_origin_is_refused(tmp_path, headers):
    async def test(site, client, _new):
        assert (await client.act({'act': 'stop'}, headers=headers))[0] == 403
        assert site.fleet.acts == []
    served(tmp_path, test)


@pytest.mark.parametrize('host', ['evil.example', 'evil.example:80', '[::1', '', '127.0.0.1.evil'])
def test_a_request_under_another_name_is_refused(tmp_path, host):
    async def test(site, client, _new):
        for path in ROUTES:
            async with client.get(path, headers={'Host': host}) as answer:
                assert answer.status == 421, path
        assert (await client.act({'act': 'stop'}, headers={
            'Host': host, 'Origin': f'http://{host}'}))[0] == 421
        assert site.fleet.acts == []
    served(tmp_path, test)


@pytest.mark.parametrize('body', [
    b'', b'{', b'[]', b'null', b'"stop"', b'\xff\xfe', b'[' * 15000, b'{"act": "stop", "x": 1}',
    b'{"act": {}}', b'{"act": "send", "destinations": [1e999]}', b'1' * 10000,
    b'{"act": "out", "robot": "a/../../b\\u0000"}', b'{"act": "cancel", "mission": NaN}'])
def test_a_body_that_makes_no_sense_is_refused(tmp_path, body):
    async def test(site, client, _new):
        for path, allowed in (('/api/act', (400,)), ('/api/login', (400, 401))):
            async with client.session.post(
                    client.url(path), data=body,
                    headers={'Origin': client.origin,
                             'Content-Type': 'application/json'}) as answer:
                assert answer.status in allowed, (path, await answer.text())
                assert 'Traceback' not in await answer.text()
        assert site.fleet.acts == []
    served(tmp_path, test)


def test_a_body_that_is_too_large_or_no_json_is_refused(tmp_path):
    async def test(site, client, _new):
        status, _ = await client.act({'act': 'add_favourite', 'name': 'x' * 100_000,
                                      'destinations': [1]})
        assert status == 413
        async with client.session.post(
                client.url('/api/act'), data='{"act": "stop"}',
                headers={'Origin': client.origin, 'Content-Type': 'text/plain'}) as answer:
            assert answer.status == 415
        assert site.fleet.acts == []
    served(tmp_path, test)


@pytest.mark.parametrize('path', [
    '/page/../package.xml', '/page/..%2f..%2fetc%2fpasswd', '/page/%2e%2e/package.xml', '/page/',
    '/page/main.js%00', '/page//etc/passwd', '/nothing', '/api/replay?time=nan',
    '/api/replay?time=-1', '/api/history?hours=x', '/api/history?hours=1e99',
    '/api/history.csv?hours=0', '/api/map.png', '/api/robot', '/api/robot?name=nobody'])
def test_a_path_or_value_that_is_not_there_is_refused(tmp_path, path):
    async def test(_site, client, _new):
        url = URL(client.origin + path, encoded=True)
        async with client.session.get(url) as answer:
            assert answer.status in (400, 404), answer.status
            assert 'root:' not in await answer.text()
    served(tmp_path, test)


@pytest.mark.parametrize('method', ['PUT', 'DELETE', 'PATCH', 'OPTIONS', 'TRACE'])
def test_other_methods_are_refused_on_every_route(tmp_path, method):
    async def test(_site, client, _new):
        for path in (*ROUTES, '/api/act'):
            async with client.session.request(method, client.url(path)) as answer:
                assert answer.status == 405
    served(tmp_path, test)


def test_a_flood_of_acts_is_held_back_and_a_stop_is_not(tmp_path):
    async def test(site, client, _new):
        seen = [(await client.act({'act': 'resume'}))[0] for _ in range(40)]
        assert seen[0] == 200 and seen[-1] == 429
        assert (await client.act({'act': 'stop'}))[0] == 200
    served(tmp_path, test)


def test_a_stop_does_not_wait_for_acts_that_take_their_time(tmp_path):
    async def test(site, client, new_client):
        site.fleet.slow = threading.Event()
        others = [asyncio.ensure_future(new_client().act({'act': 'resume'})) for _ in range(12)]
        await asyncio.sleep(0)
        try:
            answer = await asyncio.wait_for(client.act({'act': 'stop'}), 3.0)
            assert answer[0] == 200 and site.fleet.kinds == [ActKind.STOP]
        finally:
            site.fleet.slow.set()
            await asyncio.gather(*others)
    served(tmp_path, test)


def test_a_client_that_goes_leaves_its_act_recorded(tmp_path):
    async def test(site, client, _new):
        site.fleet.slow = threading.Event()
        request = asyncio.ensure_future(client.act({'act': 'resume'}))
        await asyncio.sleep(0.3)
        request.cancel()
        site.fleet.slow.set()
        await until(lambda: site.page.records.audit(1))
    served(tmp_path, test)


def test_a_journal_that_cannot_be_read_is_told(tmp_path):
    def journal(since):
        raise JournalError('There is no journal.')

    async def test(_site, client, _new):
        async with client.get('/api/history') as answer:
            assert (await answer.json())['trouble'] == 'There is no journal.'
        async with client.get('/api/history.csv') as answer:
            assert answer.status == 503
    served(tmp_path, test, journal=journal)


def test_files_come_compressed_and_only_once(tmp_path):
    async def test(_site, client, _new):
        async with client.get('/page/main.js') as answer:
            assert answer.headers['Content-Encoding'] == 'gzip'
            tag = answer.headers['ETag']
        async with client.get('/page/main.js', headers={'If-None-Match': tag}) as answer:
            assert answer.status == 304
    served(tmp_path, test)


@pytest.mark.parametrize('path', [path for path in NEED_LOGIN if path not in (
    '/api/events', '/api/map.png')])
def test_a_program_that_does_not_ask_for_compression_gets_none(tmp_path, path):
    async def test(_site, client, _new):
        async with client.get(path, skip_auto_headers=['Accept-Encoding']) as answer:
            assert 'Content-Encoding' not in answer.headers and answer.status == 200
            (await answer.read()).decode('ascii')
        async with client.get('/api/audit') as answer:
            assert 'Content-Encoding' in answer.headers
    served(tmp_path, test)


def test_an_old_chart_library_counts_as_none(tmp_path):
    (tmp_path / 'old.js').write_text('/*! Chart.js v2.9 */')

    async def test(_site, client, _new):
        async with client.get('/chart.js') as answer:
            assert answer.status == 404
    served(tmp_path, test, chart=str(tmp_path / 'old.js'))
