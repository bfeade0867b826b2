"""The form of the lines that nodes print, for the program that reads them (`start_output`).

What a line means stands in its field `logger`, never in its words.
"""
from __future__ import annotations

#: The line that says what is ready, and what a person can do: the name of its logger.
READY = 'ready'
#: The form in ROSCONSOLE_FORMAT. `logger` is rosout, or rosout.NAME.
FORM = '[${severity}] [${time}] [${logger}] ${node}: ${message}'
