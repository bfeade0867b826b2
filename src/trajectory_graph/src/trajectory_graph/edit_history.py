"""Undo and redo."""
from __future__ import annotations

from typing import List, Optional, Tuple

from trajectory_graph.editing import Draft


class History:
    """The drafts of an editing session: to undo, and to redo what was undone.

    `version` changes with every change. Changes with the same `gesture` (the drag of one handle,
    say) are undone at once.
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
        """What undo would undo, or None."""
        return self._past[-1][0] if self._past else None

    @property
    def redoable(self) -> Optional[str]:
        """What redo would do again, or None."""
        return self._future[-1][0] if self._future else None

    def change(self, name: str, draft: Draft, gesture: Optional[object] = None) -> bool:
        """Goes on to `draft`; False where that is the draft that is there."""
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
        """The next change is undone by itself, with any gesture."""
        self._gesture = None

    def undo(self) -> Optional[str]:
        """Goes back by one change; what was undone, or None."""
        return self._step(self._past, self._future)

    def redo(self) -> Optional[str]:
        """Goes forward again; what was done again, or None."""
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
