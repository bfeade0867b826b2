"""Undo and redo of changes to a draft."""
from __future__ import annotations

from typing import List, Optional, Tuple

from trajectory_graph.editing import Draft


class History:
    """The drafts of an editing session, for undo and redo.

    version -- a number that increases with every change
    gesture -- a value that all changes of one gesture have in common, e.g. the drag of a handle;
               one undo reverts all changes with the same gesture
    """

    MOST = 1000

    def __init__(self, draft: Draft) -> None:
        self._past: List[Tuple[str, Draft]] = []
        self._future: List[Tuple[str, Draft]] = []
        self._gesture: Optional[object] = None
        self.draft = draft
        self.version = 0

    @property
    def undoable(self) -> Optional[str]:
        """The name of the change that `undo` reverts, or None."""
        return self._past[-1][0] if self._past else None

    @property
    def redoable(self) -> Optional[str]:
        """The name of the change that `redo` repeats, or None."""
        return self._future[-1][0] if self._future else None

    def change(self, name: str, draft: Draft, gesture: Optional[object] = None) -> bool:
        """Makes `draft` the present draft and returns True; returns False if both are equal."""
        if draft is self.draft or draft == self.draft:
            return False
        if gesture is None or gesture != self._gesture:
            self._past.append((name, self.draft))
            del self._past[:-self.MOST]
        self._gesture = gesture
        self._future.clear()
        self.draft = draft
        self.version += 1
        return True

    def end_gesture(self) -> None:
        """Ends the gesture, so that the next change gets its own undo step."""
        self._gesture = None

    def undo(self) -> Optional[str]:
        """Reverts the last change; returns the name of the change, or None if there is none."""
        return self._step(self._past, self._future)

    def redo(self) -> Optional[str]:
        """Repeats the change that was reverted last; returns the name of the change, or None."""
        return self._step(self._future, self._past)

    def _step(self, source: List[Tuple[str, Draft]],
              target: List[Tuple[str, Draft]]) -> Optional[str]:
        self._gesture = None
        if not source:
            return None
        name, draft = source.pop()
        target.append((name, self.draft))
        self.draft = draft
        self.version += 1
        return name
