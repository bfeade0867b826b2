"""Files with passwords: reads them, and warns if other users than the owner can read them."""
from __future__ import annotations

import os
import stat

import rospy

from node_lifecycle.parameters import ConfigurationError

_MOST_BYTES = 1000


def read_password_file(path: str, what: str, is_secret: bool = True) -> bytes:
    """Returns the password in a file. Raises ConfigurationError, whose text has no password.

    what      -- name of the password, as a text for people
    is_secret -- whether to log a warning if other users can read the file
    """
    try:
        password = _content(path).strip()
    except OSError as error:
        raise ConfigurationError(f'The {what} cannot be read from file {path}: {error.strerror}.'
                                 ) from None
    problem = problem_of_password(password)
    if problem:
        raise ConfigurationError(f'There is no usable {what}: file {path} {problem}. Write nothing '
                                 'but the password into it.')
    if is_secret:
        warn_if_exposed(f'{what} file', path)
    return password


def problem_of_password(password: bytes) -> str:
    """Returns why a text cannot be a password, such as 'is empty or not set'; '' if it can be one.
    """
    if not password:
        return 'is empty or not set'
    is_plain = all(0x20 <= byte < 0x7f for byte in password)
    return '' if is_plain else 'contains control or non-ASCII characters'


def _content(path: str) -> bytes:
    """Returns the beginning of a regular file; reading another kind of file might never end."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(descriptor, 'rb') as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(0, 'it is no regular file')
        return file.read(_MOST_BYTES)


def warn_if_exposed(what: str, path: str) -> None:
    """Logs a warning if users other than the owner can read an existing file."""
    if os.stat(path).st_mode & 0o077:
        rospy.logwarn('The %s %s can be read by other users: run chmod 600 on it.', what, path)
