"""Shows findings as texts and rings in RViz."""
from __future__ import annotations

from typing import Iterable, List, Optional, Tuple

from visualization_msgs.msg import Marker

from graph_editor.checking.findings import Finding, Severity
from graph_editor.nodes.handles import AMBER, RED
from rviz_drawing import drawing, flat
from rviz_drawing.text_places import VertexText, text_size

HEIGHT, BELOW = 0.26, 0.6  # m; text height, and distance from the finding to the text's middle
LINE = 40                  # largest number of letters in a line


def finding_text(finding: Finding) -> Optional[VertexText]:
    """Returns the text of a finding; None if it has no place."""
    if finding.place is None:
        return None
    return VertexText(finding.place, text_size(_in_lines(finding), HEIGHT), (0.0, -BELOW))


def finding_markers(findings: Iterable[Tuple[Finding, Optional[Tuple[float, float]]]]
                    ) -> List[Marker]:
    """Returns a ring for each finding, and its text if a place for the text is given.

    findings -- the findings, and the middles of their texts (m)
    """
    markers = []
    for finding, words_place in findings:
        if finding.place is None:
            continue
        paint = RED if finding.severity is Severity.ERROR else AMBER
        ring = flat.disc(0.5, 0.03, drawing.colour(paint.r, paint.g, paint.b, 0.4))
        markers.append(flat.flat([ring], finding.place))
        if words_place is not None:
            markers.append(drawing.text('', 0, _in_lines(finding), words_place, HEIGHT, paint, 0.3))
    return markers


def _in_lines(finding: Finding) -> str:
    """Returns the text of a finding in short lines for a map."""
    about = f'{finding.kind} {finding.id}: ' if finding.id is not None else ''
    lines, line = [], ''
    for word in f'{about}{finding.text}'.split():
        if len(line) + len(word) > LINE:
            lines.append(line)
            line = ''
        line = f'{line} {word}'.strip()
    return '\n'.join([*lines, line])
