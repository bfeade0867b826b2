"""Tokens give roles, sessions end, and no message contains a token."""
import pytest
from page_builders import TOKENS, token_file, tokens

from fleet_page.core.rate_limits import RateLimit
from fleet_page.core.roles import (
    SESSION_TIME,
    Person,
    Sessions,
    TokenFile,
    TokenFileError,
    UserRole,
    load_tokens,
)


def test_a_token_gives_its_person_and_role(tmp_path):
    assert tokens(tmp_path).person(TOKENS['operate']) == Person('operater', UserRole.OPERATE)
    assert tokens(tmp_path).person('') is None
    assert tokens(tmp_path).person(TOKENS['admin'] + 'x') is None
    assert tokens(tmp_path).person('\ud800') is None


@pytest.mark.parametrize('mode', [0o644, 0o640, 0o604])
def test_a_token_file_that_others_may_read_is_refused(tmp_path, mode):
    with pytest.raises(TokenFileError, match='chmod 600'):
        load_tokens(token_file(tmp_path, mode))


@pytest.mark.parametrize('text, words', [
    ('', 'has no token'), ('see anna', 'line 1: the line must be ROLE NAME TOKEN'),
    ('boss anna 0123456789abcdef', 'must be see, operate or admin'),
    ('see a/b 0123456789abcdef', 'name must be'), ('see anna short', '16 characters'),
    ('see anna 0123456789abcdef\nadmin eve 0123456789abcdef', 'line 2: the token occurs twice')])
def test_a_wrong_token_file_is_told_without_its_tokens(tmp_path, text, words):
    path = tmp_path / 'tokens'
    path.write_text(text)
    path.chmod(0o600)
    with pytest.raises(TokenFileError, match=words) as error:
        load_tokens(str(path))
    assert '0123456789abcdef' not in str(error.value)


def test_a_session_ends_after_a_time_without_requests(tmp_path):
    sessions, known = Sessions(), tokens(tmp_path)
    session = sessions.open(TOKENS['see'], 0.0)
    person = Person('seer', UserRole.SEE)
    assert sessions.person(session, known, SESSION_TIME - 1.0) == person
    assert sessions.person(session, known, 2.0 * SESSION_TIME - 2.0) == person
    assert sessions.person(session, known, 4.0 * SESSION_TIME) is None
    assert sessions.person('another', known, 0.0) is None


def test_a_closed_session_is_over(tmp_path):
    sessions = Sessions()
    session = sessions.open(TOKENS['see'], 0.0)
    sessions.close(session)
    assert sessions.person(session, tokens(tmp_path), 0.0) is None


def test_a_token_that_leaves_the_file_ends_its_sessions(tmp_path):
    file = TokenFile(token_file(tmp_path))
    sessions = Sessions()
    opened = {role: sessions.open(token, 0.0) for role, token in TOKENS.items()}
    rewrite(tmp_path, f'see seer {TOKENS["see"]}\nsee operater {TOKENS["operate"]}\n')
    assert file.refresh() and not file.refresh()
    assert sessions.person(opened['admin'], file.tokens, 1.0) is None
    assert sessions.person(opened['see'], file.tokens, 1.0) == Person('seer', UserRole.SEE)
    assert sessions.person(opened['operate'], file.tokens, 1.0) == Person('operater', UserRole.SEE)


@pytest.mark.parametrize('text', [None, '', 'see anna'])
def test_a_mistake_in_the_token_file_takes_nobodys_access(tmp_path, text):
    file = TokenFile(token_file(tmp_path))
    rewrite(tmp_path, text)
    with pytest.raises(TokenFileError):
        file.refresh()
    assert not file.refresh()  # the mistake is reported only once
    assert file.tokens.person(TOKENS['operate']) is not None


def rewrite(folder, text):
    path = folder / 'tokens'
    path.unlink()
    if text is not None:
        path.write_text(text)
        path.chmod(0o600)


def test_a_rate_limit_lets_some_through_at_once_and_then_steadily():
    limit = RateLimit(3.0, 1.0)
    assert [limit.allows('a', 0.0) for _ in range(5)] == [True, True, True, False, False]
    assert limit.allows('b', 0.0)
    assert limit.allows('a', 1.0) and not limit.allows('a', 1.0)
