"""Banks of external inputs and outputs."""
from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from omron_ld90_sim.devices.external_io import Bank


@given(count=st.integers(1, 200), value=st.integers(0, 2**220), data=st.data())
def test_a_bank_never_holds_more_than_its_bits(count: int, value: int, data) -> None:
    bank = Bank(count)
    bank.update(value)
    assert bank.value == value % 2**count
    position, on = data.draw(st.integers(1, count)), data.draw(st.booleans())
    bank.set_bit(position, on)
    assert bank.value >> (position - 1) & 1 == on
    bank.set_byte((count + 7) // 8, 0xff)
    assert bank.value < 2**count and int(bank.text, 16) == bank.value
