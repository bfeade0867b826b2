"""External I/O: named banks of inputs and outputs that another device keeps up to date.

Positions of bits and bytes count from 1. Values are printed in hexadecimal, with one digit for each
whole group of four bits, and with more digits if the value needs them. All examples of ARCL manual
I617-E-02 p. 82-101 follow these rules.
"""
from __future__ import annotations

from dataclasses import dataclass

MAXIMUM_BITS = 4096         # largest size of a bank
DECIMAL_BITS = 32           # a decimal value sets only this many bits


@dataclass
class Bank:
    """The inputs or the outputs of one set."""

    count: int
    value: int = 0

    @property
    def text(self) -> str:
        """The value in hexadecimal."""
        return f'0x{self.value:0{self.count // 4}x}'

    def update(self, value: int) -> None:
        """Sets the value, without bits that the bank does not have."""
        self.value = value & ((1 << self.count) - 1)

    def set_bit(self, position: int, on: bool) -> None:
        """Sets one bit. Raises ValueError if the bank has no such position."""
        self._set(position, 1, int(on))

    def set_byte(self, position: int, value: int) -> None:
        """Sets those bits of a byte that the bank has. Raises ValueError if it has none of them."""
        self._set(position, 8, value)

    def _set(self, position: int, width: int, value: int) -> None:
        shift = (position - 1) * width
        if not 0 <= shift < self.count:
            raise ValueError(f'position {position} is not in a bank of {self.count}')
        mask = ((1 << width) - 1) << shift
        self.update(self.value & ~mask | value << shift)


@dataclass
class IoSet:
    """A named pair of banks."""

    name: str
    inputs: Bank
    outputs: Bank

    def __str__(self) -> str:
        return (f'{self.name} with {self.inputs.count} input(s), value = {self.inputs.text} and '
                f'{self.outputs.count} output(s), value = {self.outputs.text}')


def parse_value(text: str) -> int:
    """Returns a value `0x...`, or the lowest 32 bits of a decimal number; or raises ValueError."""
    value = int(text, 16) if text.lower().startswith('0x') else int(text)
    if value < 0:
        raise ValueError(f"'{text}' is negative")
    return value if text.lower().startswith('0x') else value & ((1 << DECIMAL_BITS) - 1)
