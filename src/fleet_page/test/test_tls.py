"""With TLS, the page never sends tokens and cookies unencrypted."""
from __future__ import annotations

import asyncio
import os
import shutil
import ssl
import subprocess

import pytest

pytest.importorskip('aiohttp')

from aiohttp import ClientError, ClientSession, CookieJar  # noqa: E402
from page_builders import TOKENS, ServedSite  # noqa: E402

from browser_guard.certificates import WrongCertificate, certificates_of  # noqa: E402
from fleet_page.door.door import COOKIE  # noqa: E402

pytestmark = pytest.mark.skipif(shutil.which('openssl') is None, reason='openssl is not installed')


def make_certificate(folder, name: str = 'page', *more: str):
    """Makes a certificate for this computer, and the certificate's key, as described in
    docs/reference/fleet_page.md.
    """
    certificate, key = folder / f'{name}.pem', folder / f'{name}.key'
    subprocess.run(
        ['openssl', 'req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1',
         '-days', '2', '-subj', '/CN=localhost', '-addext',
         'subjectAltName=DNS:localhost,IP:127.0.0.1', '-out', str(certificate), '-keyout', str(key),
         *(more or ('-nodes',))], check=True, stderr=subprocess.DEVNULL)
    return str(certificate), str(key)


@pytest.fixture(scope='module')
def pair(tmp_path_factory):
    return make_certificate(tmp_path_factory.mktemp('certificate'))


def served(folder, pair, test) -> None:
    """Runs test(port, client_context) with a page that uses TLS and needs a login."""
    async def work() -> None:
        site = ServedSite(folder, True, pair=pair)
        await site.open()
        try:
            await test(site.port, ssl.create_default_context(cafile=pair[0]))
        finally:
            await site.close()
    asyncio.run(work())


def test_a_login_by_tls_gets_a_cookie_that_is_sent_by_tls_only(tmp_path, pair):
    async def test(port, trust):
        url = f'https://127.0.0.1:{port}'
        async with ClientSession(cookie_jar=CookieJar(unsafe=True)) as session:
            async with session.post(f'{url}/api/login', json={'token': TOKENS['operate']},
                                    headers={'Origin': url}, ssl=trust) as answer:
                assert answer.status == 200
                cookie = answer.cookies[COOKIE]
                assert cookie['secure'] and cookie['httponly'] and cookie['samesite'] == 'Strict'
            async with session.get(f'{url}/api/site', ssl=trust) as answer:
                assert answer.status == 200
            async with session.post(f'{url}/api/act', json={'act': 'stop'}, ssl=trust, headers={
                    'Origin': f'http://127.0.0.1:{port}'}) as answer:
                assert answer.status == 403  # a page that was loaded without TLS is another origin
    served(tmp_path, pair, test)


def test_in_the_clear_nothing_is_served(tmp_path, pair):
    async def test(port, _trust):
        async with ClientSession() as session:
            with pytest.raises(ClientError):
                await session.get(f'http://127.0.0.1:{port}/api/me')
    served(tmp_path, pair, test)


def test_a_certificate_of_another_is_not_trusted(tmp_path, pair):
    async def test(port, _trust):
        async with ClientSession() as session:
            with pytest.raises(ClientError):
                await session.get(f'https://127.0.0.1:{port}/api/me')
    served(tmp_path, pair, test)


def test_files_that_make_no_certificate_are_told_in_one_sentence(tmp_path, pair):
    other = make_certificate(tmp_path, 'other')
    locked = make_certificate(tmp_path, 'locked', '-passout', 'pass:secret')
    (tmp_path / 'words').write_text('no certificate')
    for certificate, key in ((pair[0], other[1]), locked, (str(tmp_path / 'none'), ''),
                             (str(tmp_path / 'words'), ''), ('', pair[1])):
        with pytest.raises(WrongCertificate, match='cannot be used .*belong together'):
            certificates_of(certificate, key)


def test_a_key_that_everybody_may_read_is_refused_in_one_sentence(tmp_path):
    certificate, key = make_certificate(tmp_path)
    os.chmod(key, 0o644)
    with pytest.raises(WrongCertificate, match=f'Others may read the key in {key}: chmod 600'):
        certificates_of(certificate, key)
    os.chmod(key, 0o640)  # the mode of keys for Debian's group ssl-cert
    certificates_of(certificate, key)


def test_a_browser_that_came_by_tls_is_told_to_stay_with_it(tmp_path, pair):
    async def test(port, trust):
        async with ClientSession() as session:
            for path in ('/', '/api/me', '/api/site', '/nothing'):
                async with session.get(f'https://127.0.0.1:{port}{path}', ssl=trust) as answer:
                    assert 'max-age=' in answer.headers['Strict-Transport-Security'], path
    served(tmp_path, pair, test)
