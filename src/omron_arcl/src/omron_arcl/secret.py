"""Redacts passwords in lines that are stored or passed on.

The robot's configuration contains passwords, also that of our own login, which
`getConfigSectionValues ARCL server setup` prints.
"""
from __future__ import annotations

import re

REDACTED = b'********'

_CONFIGURED = re.compile(rb'(password\w*["\']?\s+)(.+?)("?\s*\' to the config)?$',
                         re.IGNORECASE | re.DOTALL)
_READS_OR_WRITES = re.compile(rb'\s*(commanderror:\s*)?'
                              rb'(getconfigsectionvalue|configadd|added |newconfigparam)',
                              re.IGNORECASE)


def redact_passwords(line: bytes) -> bytes:
    """Returns `line`. If the line reads or writes a password of the configuration, the password is
    redacted.
    """
    if not _READS_OR_WRITES.match(line):
        return line
    return _CONFIGURED.sub(rb'\g<1>' + REDACTED + rb'\g<3>', line)
