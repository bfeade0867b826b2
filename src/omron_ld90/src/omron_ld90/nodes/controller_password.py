"""The ARCL password: from a file, or from the environment."""
from __future__ import annotations

import os
import stat

import rospy

from node_lifecycle import ConfigurationError
from node_lifecycle.secret_files import warn_if_exposed

PASSWORD_VARIABLE = 'OMRON_LD90_PASSWORD'
_MAXIMUM_BYTES = 1000


def read_password(path: str, is_simulated: bool = False) -> bytes:
    """The password from `path`, or from the environment; raises ConfigurationError.

    No message ever contains it. The variable is removed from this process's environment, so that no
    program inherits it from here. But roslaunch has already written it into its own log. The
    password of a simulated robot is in the repository, so it is no secret.
    """
    variable = os.environb.pop(PASSWORD_VARIABLE.encode(), b'')
    source = f'file {path}' if path else f'environment variable {PASSWORD_VARIABLE}'
    try:
        password = _content(path).strip() if path else variable
    except OSError as error:
        raise ConfigurationError(
            f'The ARCL password cannot be read from {source}: {error.strerror}.') from None
    if not password or not all(0x20 <= byte < 0x7f for byte in password):
        what = 'contains control or non-ASCII characters' if password else 'is empty or not set'
        raise ConfigurationError(
            f'There is no usable ARCL password: {source} {what}. Set ~password_file to a file '
            f'that contains nothing but the password, or set {PASSWORD_VARIABLE}.')
    if path and not is_simulated:
        warn_if_exposed('ARCL password file', path)
    if not path:
        rospy.logwarn('The ARCL password was taken from the environment variable %s. roslaunch '
                      'writes its whole environment into its log, where others may read it: name '
                      'a file that only you can read in ~password_file instead.',
                      PASSWORD_VARIABLE)
    return password


def _content(path: str) -> bytes:
    """The beginning of a regular file; reading another kind of file might never end."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    with open(descriptor, 'rb') as file:
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            raise OSError(0, 'it is no regular file')
        return file.read(_MAXIMUM_BYTES)
