"""User name and password for a broker, from a file: in no parameter, log or process list."""
from __future__ import annotations

from typing import Tuple

import yaml


class WrongCredentials(Exception):
    """A credentials file that cannot be used; the text says what it must hold."""


def read_credentials(path: str) -> Tuple[str, str]:
    """User name and password of a YAML file with these two keys; empty ones without a file."""
    if not path:
        return '', ''
    try:
        with open(path, encoding='utf-8') as file:
            document = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError) as error:
        raise WrongCredentials(f'the credentials file {path} cannot be read: {error}') from None
    except yaml.YAMLError:  # its text would tell of the password
        document = None
    if (not isinstance(document, dict) or set(document) != {'username', 'password'}
            or not all(isinstance(value, str) for value in document.values())):
        raise WrongCredentials(f'the credentials file {path} must hold two lines, "username: ..." '
                               'and "password: ...", in quotes where they look like numbers')
    return document['username'], document['password']
