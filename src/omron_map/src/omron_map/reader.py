"""Reads a `.map` file into raw records and their values; each error names its position."""
from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Container, List, NamedTuple, Optional, Tuple

from omron_map.errors import FieldError, MapError
from omron_map.header import CATEGORIES, SCAN_KEYS, ScanHeader, parse_sources, scan_keys
from omron_map.objects import MapObject, parse_object
from omron_map.regular_file import HEAD_BYTES
from omron_map.sections import Section, is_heading, split_sections
from omron_map.text import decode, printable
from omron_map.tokens import BLANKS, Token, tokenise

BOM = b'\xef\xbb\xbf'
_LATER_CATEGORY = re.compile(r'2D-Map(-Ex[0-9]{0,3})?', re.IGNORECASE)


class Record(NamedTuple):
    """One metadata line: the bytes with the line end, the first word in lower case, the object."""

    raw: bytes
    keyword: str
    object: Optional[MapObject] = None

    @property
    def text(self) -> str:
        """The line without its line end; bytes that are not UTF-8 become surrogates."""
        return decode(self.raw).rstrip('\r\n')


@dataclass(frozen=True)
class MapContent:
    """The contents of a file: metadata records, a header for each scan source, the sections."""

    records: List[Record]
    headers: List[ScanHeader]
    sections: List[Section]


def read_content(data: bytes, name: str) -> MapContent:
    """Parses a map file. Returns its contents; raises MapError.

    data -- the bytes of the file
    name -- the name of the file, for errors
    """
    binary = data.find(b'\0')
    if binary >= 0:
        raise MapError(name, 'a zero byte: this is not text', data.count(b'\n', 0, binary) + 1,
                       expected='a text file')
    check_category(data, name)
    records, offset = _read_records(data, name)
    if offset == len(data):
        raise MapError(name, 'there is neither a LINES nor a DATA section: the file is cut off',
                       len(records), expected='at least one of them')
    headers = read_headers(records, name)
    try:
        sections = split_sections(data[offset:], len(records) + 1)
    except FieldError as error:
        raise error.in_file(name) from None
    _check_sources(sections, headers, name)
    return MapContent(records, headers, sections)


def check_category(data: bytes, name: str) -> None:
    """Raises MapError if `data`, the beginning of the file `name`, is not the beginning of a map.

    A file that was given by mistake or by malice may contain a secret, so the error does not quote
    the file.
    """
    head = data[len(BOM) if data.startswith(BOM) else 0:HEAD_BYTES]  # without a copy of the rows
    line = head.lstrip().split(b'\n', 1)[0]
    text = decode(line).strip(BLANKS)
    if not text:
        raise MapError(name, 'there is no category line' if data else 'the file is empty',
                       expected=f'a map that begins with a line like {CATEGORIES[0]}')
    if text.lower() not in (category.lower() for category in CATEGORIES):
        problem = f'{text} is not known' if _LATER_CATEGORY.fullmatch(text) else 'this is not a map'
        raise MapError(name, problem, data.count(b'\n', 0, data.find(line)) + 1, 'category',
                       ', '.join(CATEGORIES))


def _read_records(data: bytes, name: str) -> Tuple[List[Record], int]:
    """Returns the metadata, and the offset of the first section."""
    records: List[Record] = []
    start = 0
    while start < len(data):
        end = data.find(b'\n', start) + 1 or len(data)
        raw = data[start:end]
        words = raw.split(None, 1)
        keyword = decode(words[0].lower()) if words else ''
        if keyword.endswith(('data', 'lines')) and is_heading(raw):
            break
        if not records:
            keyword = keyword.lstrip('\ufeff')
        obj = _read_object(raw, name, len(records) + 1) if keyword == 'cairn:' else None
        records.append(Record(raw, keyword, obj))
        start = end
    return records, start


def _read_object(raw: bytes, name: str, number: int) -> MapObject:
    text = decode(raw).rstrip('\r\n')
    try:
        return parse_object(text, tokenise(text))
    except FieldError as error:
        raise error.in_file(name, number) from None


def read_headers(records: List[Record], name: str) -> List[ScanHeader]:
    """Returns the header of each scan in the file `name`; raises MapError."""
    number = 0
    try:
        sources = ['']
        for number, record in _with_keyword(records, ('sources:',)):  # noqa: B007
            sources = parse_sources(_values(record)) or ['']
        headers = {source: ScanHeader(source) for source in sources}
        meanings = scan_keys(sources)
        for number, record in _with_keyword(records, meanings):
            source, key = meanings[record.keyword]
            headers[source].values[key] = SCAN_KEYS[key](_values(record), key)
            headers[source].lines[key] = number
    except FieldError as error:
        raise error.in_file(name, number) from None
    return list(headers.values())


def _with_keyword(records: List[Record], keywords: Container[str]) -> List[Tuple[int, Record]]:
    return [(number, record) for number, record in enumerate(records, 1)
            if record.keyword in keywords]


def _values(record: Record) -> List[Token]:
    return tokenise(record.text)[1:]


def _check_sources(sections: List[Section], headers: List[ScanHeader], name: str) -> None:
    known = [header.source.lower() for header in headers]
    for section in sections:
        if section.source and section.source.lower() not in known:
            heading = printable(decode(section.heading).strip())
            raise MapError(name, f'the section {heading} belongs to no scan',
                           expected='its name in a Sources: line')
