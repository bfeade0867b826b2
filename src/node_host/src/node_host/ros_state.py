"""Prepares in the host the state that rospy and its libraries keep, and adapts it in each fork."""
from __future__ import annotations

import configparser
import http.client
import io
import os
import sys
import xmlrpc.client
from contextlib import suppress
from typing import Iterator

import yaml

CONFIGURATION = 'ROS_PYTHON_LOG_CONFIG_FILE'


def prepare() -> None:
    """Does once, in the host, the work that each node would otherwise do in its own memory.

    With the environment variable, a rospy node need not search all packages for its logging
    configuration. The other calls import modules or fill Python's caches, which saves 4 MB in each
    fork.
    """
    if CONFIGURATION not in os.environ:
        found = next(filter(os.path.isfile, _places()), None)
        if found:
            os.environ[CONFIGURATION] = found
    configparser.ConfigParser().read(os.environ.get(CONFIGURATION, []))
    yaml.safe_load('{key: [1, 1.5, true, text]}')
    'localhost'.encode('idna')  # sockets encode each host name in this way
    xmlrpc.client.loads(xmlrpc.client.dumps((1, 'text', ['list', {'key': 1.0}]), 'call'))
    http.client.parse_headers(io.BytesIO(b'Content-Type: text/xml\r\nContent-Length: 1\r\n\r\n'))


def _places() -> Iterator[str]:
    """Yields the paths at which a logging configuration may be, in the order of
    rosgraph.roslogging.
    """
    try:
        import rospkg
    except ImportError:
        return
    folders = [os.path.join(rospkg.get_ros_home(), 'config'), rospkg.get_etc_ros_dir()]
    with suppress(rospkg.ResourceNotFound):
        folders.append(os.path.join(rospkg.RosPack().get_path('rosgraph'), 'conf'))
    for folder in folders:
        for ending in ('conf', 'yaml'):
            yield os.path.join(folder, f'python_logging.{ending}')


def read_names() -> None:
    """Reads a fork's remappings and namespace, because rospy has read only the host's."""
    names = sys.modules.get('rospy.names')
    if names is not None:
        names.reload_mappings(sys.argv)
        names._set_caller_id(names.get_ros_namespace() + 'unnamed')
