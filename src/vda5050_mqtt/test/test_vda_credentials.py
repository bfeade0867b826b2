"""The file with the user name and password for a broker."""
from __future__ import annotations

import pytest

from vda5050_mqtt.credentials import WrongCredentials, read_credentials
from vda5050_mqtt.link import Broker


@pytest.mark.parametrize('text', [
    '', 'username: a', 'username: a\npassword: 5', '- a\n- b', 'username: [a\npassword: secret'])
def test_wrong_credentials_are_refused_and_not_told(tmp_path, text):
    file = tmp_path / 'credentials.yaml'
    file.write_text(text)
    with pytest.raises(WrongCredentials) as caught:
        read_credentials(str(file))
    assert 'secret' not in str(caught.value)


def test_credentials_are_read_and_shown_nowhere(tmp_path):
    file = tmp_path / 'credentials.yaml'
    file.write_text('username: lab\npassword: "Cormorant 7"\n')
    username, password = read_credentials(str(file))
    assert (username, password) == ('lab', 'Cormorant 7')
    assert 'Cormorant' not in f'{Broker("host", 1883, username, password)!r}'
    assert read_credentials('') == ('', '')
