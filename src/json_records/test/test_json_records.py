"""Written values are read back unchanged; all other data is refused."""
from __future__ import annotations

import json
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from json_records import from_json, to_json


class Colour(Enum):
    RED = 'red'
    BLUE = 'blue'


class Level(IntEnum):
    LOW = 1
    HIGH = 2


class Place(NamedTuple):
    x: float
    y: float
    level: Level = Level.LOW


@dataclass(frozen=True)
class Wheel:
    number: int
    colour: Colour = Colour.RED


@dataclass(frozen=True)
class Cart:
    name: str
    wheels: Tuple[Wheel, ...] = ()
    place: Optional[Place] = None
    span: Tuple[int, float] = (0, 0.0)
    notes: List[str] = ()
    loads: Dict[str, Wheel] = ()
    is_old: bool = False
    rest: Any = None


finite = st.floats(allow_nan=False)
wheels = st.builds(Wheel, st.integers(), st.sampled_from(Colour))
places = st.builds(Place, finite, finite, st.sampled_from(Level))
carts = st.builds(
    Cart, st.text(), st.lists(wheels).map(tuple), st.none() | places,
    st.tuples(st.integers(), finite), st.lists(st.text()),
    st.dictionaries(st.text(), wheels), st.booleans(), st.none() | st.integers())


@given(carts)
def test_what_was_written_is_read(cart):
    assert from_json(Cart, json.loads(json.dumps(to_json(cart)))) == cart


CART = to_json(Cart('a', notes=[], loads={}))


@pytest.mark.every_python
def test_fields_that_an_older_version_did_not_write_have_their_defaults():
    older = {key: value for key, value in CART.items() if key not in ('place', 'is_old')}
    assert from_json(Cart, older, added=('place', 'is_old')) == Cart('a', notes=[], loads={})
    with pytest.raises(ValueError, match='Cart has other fields'):
        from_json(Cart, older, added=('place',))


@pytest.mark.every_python
@pytest.mark.parametrize('wrong', [
    {'name': 5}, {'wheels': [{'number': '1'}]}, {'wheels': {}}, {'wheels': 'ab'},
    {'wheels': [{'number': 1, 'colour': 'green'}]}, {'wheels': [{}]}, {'place': [1.0, 2.0]},
    {'place': [1.0, 2.0, 3]}, {'place': [1.0, 2.0, 1, 1]}, {'span': [1]}, {'notes': 'text'},
    {'loads': []}, {'is_old': 1}, {'doors': 2}])
def test_what_is_not_of_the_type_is_refused(wrong):
    with pytest.raises((TypeError, ValueError)):
        from_json(Cart, {**CART, **wrong})


@pytest.mark.every_python
@pytest.mark.parametrize('found', [None, [], 'cart', 5])
def test_a_record_is_an_object(found):
    with pytest.raises(TypeError):
        from_json(Cart, found)


@pytest.mark.every_python
def test_a_field_can_be_read_as_a_narrower_type():
    assert from_json(Cart, {**CART, 'rest': {'number': 3, 'colour': 'blue'}},
                     instead={'rest': Wheel}).rest == Wheel(3, Colour.BLUE)
