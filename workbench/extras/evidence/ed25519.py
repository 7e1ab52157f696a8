"""Ed25519 signatures, verified only: RFC 8032, section 5.1.7, in the letters of that document.

It is slow and takes another time for each signature, which does not matter: nothing here is secret.
"""

import hashlib
from typing import Any

P = 2**255 - 19
ORDER = 2**252 + 27742317777372353535851937790883648493
D = -121665 * pow(121666, P - 2, P) % P


def _x(y: int, is_odd: int) -> int | None:
    """The x of a point, which has two: modulo P a root of (y^2 - 1) / (d y^2 + 1)."""
    square = (y * y - 1) * pow(D * y * y + 1, P - 2, P) % P
    x = pow(square, (P + 3) // 8, P)
    if (x * x - square) % P:
        x = x * pow(2, (P - 1) // 4, P) % P
    if (x * x - square) % P or (x == 0 and is_odd):
        return None
    return x if x % 2 == is_odd else P - x


def _point(packed: bytes) -> Any:
    value = int.from_bytes(packed, "little")
    y, is_odd = value & (2**255 - 1), value >> 255
    x = _x(y, is_odd) if y < P else None
    return None if x is None else (x, y, 1, x * y % P)


def _sum(first: Any, second: Any) -> Any:
    a, b = (
        (first[1] - first[0]) * (second[1] - second[0]),
        (first[1] + first[0]) * (second[1] + second[0]),
    )
    c, d = 2 * first[3] * second[3] * D, 2 * first[2] * second[2]
    e, f, g, h = b - a, d - c, d + c, b + a
    return e * f % P, g * h % P, f * g % P, e * h % P


def _times(factor: int, point: Any) -> Any:
    result = (0, 1, 1, 0)
    while factor:
        if factor & 1:
            result = _sum(result, point)
        point, factor = _sum(point, point), factor >> 1
    return result


def _pack(point: Any) -> bytes:
    inverse = pow(point[2], P - 2, P)
    x, y = point[0] * inverse % P, point[1] * inverse % P
    return (y | (x & 1) << 255).to_bytes(32, "little")


BASE = _point((4 * pow(5, P - 2, P) % P).to_bytes(32, "little"))


def is_signed(public_key: bytes, signature: bytes, message: bytes) -> bool:
    """Whether an Ed25519 signature (64 bytes) is that of a message with a key (32 bytes)."""
    key = _point(public_key) if len(public_key) == 32 else None
    if key is None or len(signature) != 64:
        return False
    half, s = signature[:32], int.from_bytes(signature[32:], "little")
    if s >= ORDER:
        return False
    h = int.from_bytes(hashlib.sha512(half + public_key + message).digest(), "little") % ORDER
    negative = (P - key[0], key[1], 1, P - key[3])
    return _pack(_sum(_times(s, BASE), _times(h, negative))) == half
