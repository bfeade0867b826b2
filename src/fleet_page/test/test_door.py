"""STOP works even under floods of requests, and while the page's process hangs."""
from __future__ import annotations

import asyncio
import threading
import time
import zlib

import pytest

pytest.importorskip('aiohttp')

from page_builders import TOKENS, until  # noqa: E402
from test_web_server import served  # noqa: E402

from fleet_page.core.acts import ActKind, ActOutcome  # noqa: E402
from fleet_page.core.admissions import MOST, MOST_OF_ADDRESS  # noqa: E402
from fleet_page.door import connections as connections_module  # noqa: E402
from fleet_page.door import worker as worker_module  # noqa: E402
from fleet_page.door.stops import Stops  # noqa: E402

STOP = {'act': 'stop'}
QUICK = 0.5  # s; in these tests a STOP that waits for anything takes far longer


async def connect(client, *lines: str, address: str = '127.0.0.1'):
    """Opens a connection, sends only these lines of a request, and returns the connection."""
    port = int(client.origin.rpartition(':')[2])
    reader, writer = await asyncio.open_connection('127.0.0.1', port, local_addr=(address, 0))
    writer.write(''.join(f'{line}\r\n' for line in lines).encode())
    return reader, writer


async def ended(reader, seconds: float = 5.0) -> bytes:
    """Returns all bytes that come until the other side ends the connection."""
    try:
        return await asyncio.wait_for(reader.read(), seconds)
    except ConnectionResetError:
        return b''


async def stopped_in(client) -> float:
    """Stops the fleet on a new connection; returns the time (s) until the stop has succeeded."""
    begun = time.monotonic()
    status, answer = await client.act(STOP)
    assert status == 200 and answer['ok'], answer
    return time.monotonic() - begun


def connections(site):
    """Returns the admissions of the door, which limit its connections."""
    return site.door._listener.admissions


@pytest.mark.parametrize('lines', [(), ('GET / HTTP/1.1',), ('GET / HTTP/1.1', 'Host: a', 'X: y')])
def test_half_a_request_is_not_waited_for_long(tmp_path, monkeypatch, lines):
    monkeypatch.setattr(connections_module, 'HEAD_WITHIN', 0.3)

    async def test(site, client, _new):
        reader, writer = await connect(client, *lines)
        await until(lambda: len(connections(site)) == 1)
        assert await ended(reader) == b''
        await until(lambda: len(connections(site)) == 0)
        writer.close()
    served(tmp_path, test)


def test_half_a_second_request_is_not_waited_for_long(tmp_path, monkeypatch):
    monkeypatch.setattr(connections_module, 'HEAD_WITHIN', 0.3)

    async def test(site, client, _new):
        host = client.origin.partition('//')[2]
        reader, writer = await connect(client, 'GET /api/me HTTP/1.1', f'Host: {host}', '')
        assert b'200' in await reader.readline()
        writer.write(b'GET /api/me HTTP/1.1\r\n')
        await ended(reader)
        writer.close()
    served(tmp_path, test, secured=True)


def test_a_body_that_does_not_come_is_not_waited_for_long(tmp_path, monkeypatch):
    from fleet_page.door import door as door_module
    monkeypatch.setattr(door_module, 'HEAD_WITHIN', 0.3)

    async def test(_site, client, _new):
        host = client.origin.partition('//')[2]
        for path in ('/api/login', '/api/act'):
            reader, writer = await connect(
                client, f'POST {path} HTTP/1.1', f'Host: {host}', f'Origin: {client.origin}',
                'Content-Type: application/json', 'Content-Length: 100', '', '{')
            assert b'408' in await asyncio.wait_for(reader.readline(), 5.0)
            writer.close()
    served(tmp_path, test)


def test_half_requests_of_one_address_leave_stop_to_the_others(tmp_path):
    async def test(site, client, new_client):
        await client.login('operate')
        flood = [await connect(client, 'POST /api/act HTTP/1.1', address='127.0.0.9')
                 for _ in range(300)]
        assert connections(site).of_address('127.0.0.9') <= MOST_OF_ADDRESS
        assert await stopped_in(client) < QUICK
        newcomer = new_client('127.0.0.2')
        await newcomer.login('operate')
        assert await stopped_in(newcomer) < QUICK
        for _, writer in flood:
            writer.close()
    served(tmp_path, test, secured=True)


def test_half_requests_of_the_own_address_leave_stop_its_place(tmp_path):
    async def test(_site, client, new_client):
        flood = [await connect(client, 'POST /api/act HTTP/1.1')
                 for _ in range(MOST_OF_ADDRESS + 10)]
        assert await stopped_in(client) < QUICK
        for _, writer in flood:
            writer.close()
    served(tmp_path, test)


def test_half_requests_of_many_addresses_leave_stop_its_place(tmp_path):
    async def test(site, client, new_client):
        flood = [await connect(client, 'POST /api/act HTTP/1.1', address=f'127.0.3.{1 + n % 60}')
                 for n in range(600)]
        assert len(connections(site)) <= MOST
        assert await stopped_in(new_client('127.0.0.2')) < QUICK
        for _, writer in flood:
            writer.close()
    served(tmp_path, test)


@pytest.mark.parametrize('header', ['Content-Encoding: gzip', 'content-encoding:deflate',
                                    'CONTENT-ENCODING :br', 'Content-Encoding: identity'])
@pytest.mark.parametrize('is_split', [False, True])
def test_a_compressed_body_is_refused_before_it_is_expanded(tmp_path, header, is_split):
    body = zlib.compress(bytes(30_000_000))

    async def test(_site, client, _new):
        host = client.origin.partition('//')[2]
        reader, writer = await connect(
            client, 'POST /api/login HTTP/1.1', f'Host: {host}', f'Origin: {client.origin}',
            'Content-Type: application/json', f'Content-Length: {len(body)}')
        if is_split:
            writer.write(header[:9].encode())
            await writer.drain()
            await asyncio.sleep(0)
            writer.write(header[9:].encode())
        else:
            writer.write(header.encode())
        writer.write(b'\r\n\r\n' + body)
        assert b'415' in (await ended(reader)).splitlines()[0]
        writer.close()
    served(tmp_path, test)


def test_stop_works_while_the_page_hangs_and_is_recorded_when_it_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(worker_module, 'ANSWER_WITHIN', 0.5)

    async def test(site, client, _new):
        await client.login('operate')
        await site.hang()
        async with client.get('/api/site') as answer:
            assert answer.status == 503 and 'STOP ALL works' in (await answer.json())['text']
        assert await stopped_in(client) < QUICK
        async with client.get('/') as answer:
            assert answer.status == 200
        assert site.page.records.audit(5) == []
        await site.go_on()
        await until(lambda: site.page.records.audit(5))
        row, = site.page.records.audit(5)
        assert (row['act'], row['person'], row['ok']) == ('stop', 'operater', True)
    served(tmp_path, test, secured=True)


def test_requests_that_the_page_does_not_answer_take_no_place_of_a_stop(tmp_path):
    async def test(site, client, new_client):
        await client.login('see')
        await site.hang()
        waiting = [asyncio.ensure_future(client.get('/api/site').__aenter__()) for _ in range(100)]
        await until(lambda: sum(site.door._relayed.values()) == 60)
        operator = new_client('127.0.0.2')
        await operator.login('operate')
        assert await stopped_in(operator) < QUICK
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        await client.session.close()
        await until(lambda: not site.door._relayed)  # a client that has ended holds no place
        await site.go_on()
    served(tmp_path, test, secured=True)


def test_a_browser_cannot_say_itself_who_it_is(tmp_path):
    async def test(site, client, _new):
        for headers in ({}, {'X-Person': 'boss', 'X-Role': 'ADMIN'}):
            async with client.get('/api/site', headers=headers) as answer:
                assert answer.status == 401
        await client.login('see')
        async with client.get('/api/audit', headers={'X-Role': 'ADMIN'}) as answer:
            assert answer.status == 403
        for path in ('/stopped', '/api/stopped', '/api/../stopped', '/page/../stopped'):
            async with client.post(path, {'person': 'x', 'ok': True, 'text': '', 'time': 1}) as it:
                assert it.status in (404, 405), path
        assert site.page.records.audit(5) == []
    served(tmp_path, test, secured=True)


def test_many_who_ask_for_a_stop_at_once_share_one_that_began_after_they_asked():
    begun, may_end = [], threading.Event()

    def stop(person: str) -> ActOutcome:
        begun.append(len(begun))
        may_end.wait(5.0)
        return ActOutcome(True, f'stop {begun[-1]}')

    async def work() -> None:
        stops = Stops(stop)
        first = asyncio.ensure_future(stops.stop('anna'))
        await until(lambda: begun == [0])
        others = [asyncio.ensure_future(stops.stop('anna')) for _ in range(50)]
        others[0].cancel()
        await asyncio.sleep(0)
        may_end.set()
        assert (await first).text == 'stop 0'
        assert {outcome.text for outcome in await asyncio.gather(*others[1:])} == {'stop 1'}
        assert (await stops.stop('anna')).text == 'stop 2'
        stops.close()
    asyncio.run(work())


def test_a_stop_that_fails_once_can_be_asked_again():
    outcomes = iter([ActOutcome(False, 'no robot'), ActOutcome(True, 'stopped')])

    async def work() -> None:
        stops = Stops(lambda person: next(outcomes))
        assert not (await stops.stop('anna')).ok
        assert (await stops.stop('anna')).ok
        stops.close()
    asyncio.run(work())


def test_a_stop_of_one_who_only_sees_is_refused(tmp_path):
    async def test(site, client, _new):
        assert await client.login('see') == 200 and TOKENS
        assert (await client.act(STOP))[0] == 403
        assert ActKind.STOP not in site.fleet.kinds
    served(tmp_path, test, secured=True)
