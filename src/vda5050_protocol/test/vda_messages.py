"""Messages of a master on the wire, for the tests of all VDA 5050 packages."""
from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Mapping

ROOT = Path(__file__).resolve().parents[3]


def payload(message: Mapping[str, Any], header_id: int = 0, version: str = '2.1.0') -> bytes:
    """Returns the bytes of a message of the master on the wire."""
    header = {'headerId': header_id, 'timestamp': '2026-01-01T00:00:00.00Z', 'version': version,
              'manufacturer': 'OMRON', 'serialNumber': 'lab'}
    return json.dumps({**header, **message}).encode()
