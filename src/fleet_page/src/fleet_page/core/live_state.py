"""The newest state as entries with keys.

The server keeps no queue for a client, only the last revision that the client has. A slow client
gets the newest state when it reads again. A client that does not read costs nothing.
"""
from __future__ import annotations

import json
from collections import OrderedDict
from typing import Any, Dict, List, Mapping, Optional, Tuple

from fleet_page.core.layers import ShownLayers

MOST_GONE = 5000  # removed keys that are kept; a client that needs older keys gets all entries
_KEPT_TEXTS = 16  # updates that are kept as text, because nearly all clients need the same update
ALL = ShownLayers()


class LiveState:
    """Entries with JSON values, by key."""

    def __init__(self) -> None:
        self.revision = 1
        self._entries: Dict[str, Tuple[int, Any]] = {}
        self._gone: OrderedDict[str, int] = OrderedDict()
        self._oldest = 0  # a client with an older revision may have missed removals
        self._texts: OrderedDict[Tuple[int, int, ShownLayers], str] = OrderedDict()

    def put(self, key: str, value: Any) -> None:
        """Sets an entry. An equal value is no change."""
        known = self._entries.get(key)
        if known is not None and known[1] == value:
            return
        self.revision += 1
        self._gone.pop(key, None)
        # The entry moves to the end: `_update` needs the newest entries last.
        self._entries.pop(key, None)
        self._entries[key] = (self.revision, value)

    def get(self, key: str) -> Optional[Any]:
        """Returns the value of an entry; None if it does not exist."""
        known = self._entries.get(key)
        return None if known is None else known[1]

    def remove(self, key: str) -> None:
        """Removes an entry if it exists."""
        if self._entries.pop(key, None) is None:
            return
        self.revision += 1
        self._gone[key] = self.revision
        while len(self._gone) > MOST_GONE:
            self._oldest = self._gone.popitem(last=False)[1]

    def replace(self, prefix: str, values: Mapping[str, Any]) -> None:
        """Replaces all entries whose keys begin with `prefix`. `values` has keys without the
        prefix.
        """
        for key in [key for key in self._entries
                    if key.startswith(prefix) and key[len(prefix):] not in values]:
            self.remove(key)
        for name, value in values.items():
            self.put(prefix + name, value)

    def entries(self, prefix: str) -> Dict[str, Any]:
        """Returns all entries whose keys begin with a prefix, by the part of the key after the
        prefix.
        """
        return {key[len(prefix):]: value for key, (_, value) in self._entries.items()
                if key.startswith(prefix)}

    def update(self, seen: int, layers: ShownLayers = ALL) -> str:
        """Returns the update (JSON) for a client that has the revision `seen` and shows `layers`.

        Its fields are `revision`, `full` (true: the client must drop all other entries), `set`
        (values by key) and `gone` (removed keys). The text is empty if nothing that the client
        shows has changed.
        """
        is_full = not self._oldest <= seen <= self.revision or seen <= 0
        wanted = (0 if is_full else seen, self.revision, layers)
        text = self._texts.get(wanted)
        if text is None:
            text = self._texts[wanted] = self._update(*wanted)
            while len(self._texts) > _KEPT_TEXTS:
                self._texts.popitem(last=False)
        return text

    def nothing_new(self) -> str:
        """Returns an update without changes. It shows a client that the server still works."""
        return _update_text(self.revision, False, {}, [])

    def _update(self, seen: int, revision: int, layers: ShownLayers) -> str:
        changed: Dict[str, Any] = {}
        for key in reversed(self._entries):
            since, value = self._entries[key]
            if since <= seen:
                break
            if layers.shows(key):
                changed[key] = value
        gone = [] if not seen else [key for key, since in self._gone.items()
                                    if since > seen and layers.shows(key)]
        return _update_text(revision, not seen, changed, gone) if (
            changed or gone or not seen) else ''


def _update_text(revision: int, full: bool, changed: Dict[str, Any], gone: List[str]) -> str:
    return json.dumps({'revision': revision, 'full': full, 'set': changed, 'gone': gone},
                      separators=(',', ':'), allow_nan=False)
