"""The bytes of Unitree's low-level messages."""

import numpy as np
import pytest
from hardwaretools import bitwise_checksum, flipped_bit

from wbc.hardware.unitree.messages import LOW_COMMAND, LOW_STATE, MessageBuffer, checksum


@pytest.mark.parametrize(("dtype", "size"), [(LOW_COMMAND, 1004), (LOW_STATE, 2092)])
def test_messages_have_the_size_of_the_maker_s(dtype: np.dtype, size: int) -> None:
    assert dtype.itemsize == size
    assert len(MessageBuffer(dtype).encode()) == size


def test_the_checksum_is_that_of_its_definition() -> None:
    body = np.random.default_rng(0).bytes(1004)
    assert checksum(body) == bitwise_checksum(body)


def test_a_message_is_decoded_as_it_was_encoded_unless_a_bit_is_flipped() -> None:
    sent, received = MessageBuffer(LOW_STATE), MessageBuffer(LOW_STATE)
    sent.fields["motor_state"]["q"][0] = np.arange(35)
    sent.fields["tick"] = 123456
    data = sent.encode()
    assert not received.decode(flipped_bit(data))
    assert not received.decode(data[:-4])
    assert not received.fields["tick"].any()
    assert received.decode(data)
    assert received.fields["tick"][0] == 123456
    np.testing.assert_array_equal(received.fields["motor_state"]["q"][0], np.arange(35))


def test_padding_may_hold_anything_on_the_wire() -> None:
    sent, received = MessageBuffer(LOW_COMMAND), MessageBuffer(LOW_COMMAND)
    sent.fields["mode_machine"] = 5
    data = sent.encode()
    assert received.decode(data[:7] + b"\x07" + data[8:])
    assert received.encode() == data
