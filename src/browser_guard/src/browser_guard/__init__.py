"""Distinguishes requests of web browsers from requests of programs.

A browser that shows a web page sends the page's requests to every address that the browser reaches:
to a ROS master, a ROS node, or a control port. The page cannot read the answer, but the request
would be carried out. These rules recognise such requests:

- The first line of an HTTP request is no line of a line protocol (`is_http_request`).
- An XML-RPC server of ROS refuses requests that programs of ROS never send (`reason_to_refuse`). A
  browser sends `Origin` with each POST, and a page of another site cannot choose the content type
  `text/xml`. A site can change the address of its name to an address here (DNS rebinding). Then the
  header `Host` has a name that this computer does not have.
"""
from __future__ import annotations

import ipaddress
import os
import re
import socket
from functools import lru_cache
from typing import Callable, Iterable, Mapping, Optional, Set, Tuple

CONTENT_TYPE = 'text/xml'
LARGEST_BODY = 16 * 2**20  # bytes of an XML-RPC request, e.g. of the parameters of a launch file
_REQUEST_LINE = re.compile(rb'\S+ \S+ HTTP/\d(\.\d)?\s*\Z')
_OF_BROWSERS = ('origin', 'sec-')  # headers that browsers add, and that a page cannot remove
_HOST_OF_URI = re.compile(r'\w+://(?:[^/@]*@)?([^/]*)')


def is_http_request(first_line: bytes) -> bool:
    """Returns whether the first line of a connection begins an HTTP request."""
    return _REQUEST_LINE.match(first_line) is not None


def is_from_browser(names: Iterable[str]) -> bool:
    """Returns whether headers with these names come from a browser that runs a web page."""
    return any(name.lower().startswith(_OF_BROWSERS) for name in names)


def reason_to_refuse(method: str, headers: Iterable[Tuple[str, str]],
                     hosts: OwnHosts) -> Optional[str]:
    """Returns why an XML-RPC server of ROS refuses an HTTP request; None: it accepts the request.
    """
    by_name = {name.lower(): value.strip() for name, value in headers}
    if method != 'POST':
        return 'only POST is accepted'
    if is_from_browser(by_name):
        return 'web browsers are refused'
    if by_name.get('content-type', '').partition(';')[0].strip().lower() != CONTENT_TYPE:
        return f'the content type must be {CONTENT_TYPE}'
    if 'host' in by_name and by_name['host'] not in hosts:
        return ('this computer does not have the name in the Host header: use its address, or set '
                'ROS_HOSTNAME on it to this name')
    length = by_name.get('content-length', '')
    if not (length.isascii() and length.isdigit() and len(length) < 10
            and int(length) <= LARGEST_BODY):
        return f'the length of the body must be known, and at most {LARGEST_BODY} bytes'
    return None


class OwnHosts:
    """The values of the header Host under which programs reach this computer.

    The computer knows these values without a setting:

    - every IP address, and every name without a dot, because no web page has such a name
    - `localhost`, the host name, and the host name under `.local` (mDNS)
    - the names in ROS_HOSTNAME, ROS_IP and ROS_MASTER_URI
    - the full name of the computer, which is looked up only if no other rule fits
    """

    def __init__(self, environment: Mapping[str, str] = os.environ,
                 host_name: Callable[[], str] = socket.gethostname,
                 full_name: Callable[[], str] = lru_cache(None)(socket.getfqdn)) -> None:
        self._environment = environment
        self._host_name = host_name
        self._full_name = full_name

    def __contains__(self, header: object) -> bool:
        """Whether programs may use this value of the header Host."""
        host = _host(str(header))
        return (_is_address(host) or '.' not in host or host.endswith('.localhost')
                or host in self._names() or host == _host(self._full_name()))

    def _names(self) -> Set[str]:
        own = _host(self._host_name())
        given = [self._environment.get(name, '') for name in ('ROS_HOSTNAME', 'ROS_IP')]
        master = _HOST_OF_URI.match(self._environment.get('ROS_MASTER_URI', ''))
        if master is not None:
            given.append(master.group(1))
        return {own, f'{own}.local', *map(_host, given)}


def _host(text: str) -> str:
    """Returns a host without its port, in a form for comparisons."""
    bracketed = re.match(r'\[([^\]]*)\](?::\d*)?\Z', text)
    if bracketed is not None:
        return bracketed.group(1).lower()
    name, colon, port = text.rpartition(':')
    if colon and ':' not in name and (port.isdigit() or not port):
        text = name
    return text.lower().rstrip('.')


def _is_address(host: str) -> bool:
    if ':' in host:
        host = host.partition('%')[0]  # without the zone of a link-local address
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
