"""The form of the lines that nodes print, for the program that reads them (`start_output`).

The field `logger` says what a line means; its words do not.
"""
from __future__ import annotations

#: The name of the logger of the line that says what is ready and what a person can do.
READY = 'ready'
#: The form in ROSCONSOLE_FORMAT. `logger` is rosout, or rosout.NAME.
FORM = '[${severity}] [${time}] [${logger}] ${node}: ${message}'
