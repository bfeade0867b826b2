"""Reads the user name and password for a broker from a file.

So user name and password do not appear in a parameter, a log or the process list.
"""
from __future__ import annotations

from typing import Tuple

import yaml


class WrongCredentials(Exception):
    """A credentials file that cannot be used; the text says what the file must contain."""


def read_credentials(path: str) -> Tuple[str, str]:
    """Returns the user name and password in a YAML file; both are empty if `path` is empty.

    The file has the two keys `username` and `password`. Raises WrongCredentials.
    """
    if not path:
        return '', ''
    try:
        with open(path, encoding='utf-8') as file:
            document = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError) as error:
        raise WrongCredentials(f'the credentials file {path} cannot be read: {error}') from None
    except yaml.YAMLError:  # the text of this error may contain the password
        document = None
    if (not isinstance(document, dict) or set(document) != {'username', 'password'}
            or not all(isinstance(value, str) for value in document.values())):
        raise WrongCredentials(f'the credentials file {path} must contain two lines, "username: '
                               '..." and "password: ..."; put values that look like numbers in '
                               'quotes')
    return document['username'], document['password']
