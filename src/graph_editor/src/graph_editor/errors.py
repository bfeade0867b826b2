"""The errors of this package; the text of each is one sentence for people."""
from __future__ import annotations


class SiteError(Exception):
    """A map or options from which a floor or a graph cannot be made."""
