"""Passwords of the robot's configuration are redacted, and nothing else is."""
from __future__ import annotations

import pytest

from omron_arcl.secret import redact_passwords


@pytest.mark.parametrize(('line', 'redacted'), [
    (b'GetConfigSectionValue: Password adept', b'GetConfigSectionValue: Password ********'),
    (b'configAdd Password two words', b'configAdd Password ********'),
    (b"Added 'Password adept' to the config", b"Added 'Password ********' to the config"),
    (b'configAdd PasswordUser adept', b'configAdd PasswordUser ********'),
    (b'GetConfigSectionValue: PortNumber 7171', b'GetConfigSectionValue: PortNumber 7171'),
    (b'say the password is adept', b'say the password is adept'),
    (b'Going to password', b'Going to password'),
])
def test_the_value_of_a_password_is_redacted(line, redacted):
    assert redact_passwords(line) == redacted
