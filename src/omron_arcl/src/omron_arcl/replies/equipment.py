"""Replies about range devices, inputs and outputs, and payload."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from omron_arcl.replies.reply import Reply

if TYPE_CHECKING:
    import numpy.typing as npt  # not in the numpy of Ubuntu 20.04


@dataclass(frozen=True)
class RangeDevice(Reply):
    """A range device of the robot, e.g. `Laser_1`, and its kind."""

    name: str
    kind: str


@dataclass(frozen=True, eq=False)
class RangeReading(Reply):
    """Points that a range device sees: (N, 2) int64, mm, in the map frame; read only.

    `cumulative` points are remembered for some time, others belong to one scan.
    """

    device: str
    points: npt.NDArray[np.int64]
    cumulative: bool = False

    def __eq__(self, other: object) -> bool:
        return (isinstance(other, RangeReading) and self.device == other.device
                and self.cumulative == other.cumulative
                and np.array_equal(self.points, other.points))

    def __hash__(self) -> int:
        return hash((self.device, self.cumulative, self.points.tobytes()))


@dataclass(frozen=True)
class Input(Reply):
    """A digital input or output (`output`). `state`: on, off or broken; '' in a list of names."""

    name: str
    state: str
    output: bool = False


@dataclass(frozen=True)
class ExternalIO(Reply):
    """A set of external inputs and outputs: their numbers, and their values as bits."""

    name: str
    inputs: int
    input_bits: int
    outputs: int
    output_bits: int


@dataclass(frozen=True)
class ExternalIOUpdate(Reply):
    """The inputs (or, `output`, the outputs) of an external set now have the values `bits`."""

    name: str
    output: bool
    bits: int


@dataclass(frozen=True)
class PayloadSlot(Reply):
    """The content of a payload slot; the robot writes `Empty` for nothing.

    Only a fleet manager names the `robot`.
    """

    slot: int
    content: str
    robot: str = ''
