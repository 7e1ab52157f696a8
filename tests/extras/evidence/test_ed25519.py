"""Signatures are verified as RFC 8032 says, and as the library that makes them does."""

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.extras.evidence.ed25519 import ORDER, is_signed

# RFC 8032, section 7.1: TEST 1 and TEST 2.
VECTORS = (
    (
        "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a",
        "e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555"
        "fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b",
        "",
    ),
    (
        "3d4017c3e843895a92b70aa74d1b7ebc9c982ccf2ec4968cc0cd55f12af4660c",
        "92a009a9f0d4cab8720e820b5f642540a2b27b5416503f8fb3762223ebdb69da"
        "085ac1e43e15996e458f3613d0f11d8c387b2eaeb4302aeeb00d291612bb0c00",
        "72",
    ),
)


@pytest.mark.parametrize(("key", "signature", "message"), VECTORS)
def test_the_vectors_of_the_standard_hold(key, signature, message):
    assert is_signed(*map(bytes.fromhex, (key, signature, message)))


@settings(max_examples=20, deadline=None)
@given(st.binary(min_size=32, max_size=32), st.binary(max_size=300), st.integers(0, 511))
def test_what_the_library_signs_holds_and_one_bit_elsewhere_does_not(seed, message, bit):
    key = Ed25519PrivateKey.from_private_bytes(seed)
    public, signature = key.public_key().public_bytes_raw(), key.sign(message)
    assert is_signed(public, signature, message)
    bent = bytearray(signature)
    bent[bit // 8] ^= 1 << bit % 8
    assert not is_signed(public, bytes(bent), message)
    assert not is_signed(public, signature, message + b"x")
    other = bytearray(public)
    other[bit % 32] ^= 1
    assert not is_signed(bytes(other), signature, message)


def test_no_second_signature_can_be_made_of_one():
    key = Ed25519PrivateKey.from_private_bytes(b"1" * 32)
    public, signature = key.public_key().public_bytes_raw(), key.sign(b"x")
    s = int.from_bytes(signature[32:], "little") + ORDER
    assert not is_signed(public, signature[:32] + s.to_bytes(32, "little"), b"x")


@pytest.mark.parametrize("key", [b"", b"\xff" * 32, b"\x02" + b"\x00" * 31])
def test_what_is_no_point_is_no_key(key):
    assert not is_signed(key, b"\x00" * 64, b"")
    assert not is_signed(key, b"", b"")
