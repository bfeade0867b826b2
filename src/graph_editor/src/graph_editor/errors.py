"""What can go wrong between a map and a graph; the text of each is one sentence for people."""
from __future__ import annotations


class SiteError(Exception):
    """A map, or options, of which no floor or no graph can be made."""
