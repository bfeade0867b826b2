"""The ARCL password: from a file, or from the environment."""
from __future__ import annotations

import os

import rospy

from node_lifecycle import ConfigurationError
from node_lifecycle.secret_files import problem_of_password, read_password_file

PASSWORD_VARIABLE = 'OMRON_LD90_PASSWORD'


def read_password(path: str, is_simulated: bool = False) -> bytes:
    """Returns the password from `path`, or from the environment; raises ConfigurationError.

    No message ever contains the password. The variable is removed from the environment of this
    process, so that no program inherits it from this node. But roslaunch has already written it
    into its own log. The password of a simulated robot is in the repository, so it is no secret.
    """
    password = os.environb.pop(PASSWORD_VARIABLE.encode(), b'')
    if path:
        return read_password_file(path, 'ARCL password', is_secret=not is_simulated)
    problem = problem_of_password(password)
    if problem:
        raise ConfigurationError(
            f'There is no usable ARCL password: set ~password_file to a file that contains nothing '
            f'but the password. (Environment variable {PASSWORD_VARIABLE} {problem}.)')
    rospy.logwarn('The ARCL password was taken from the environment variable %s. roslaunch '
                  'writes its whole environment into its log, where others may read it: name '
                  'a file that only you can read in ~password_file instead.', PASSWORD_VARIABLE)
    return password
