"""Physics steps on disk: losslessly packed columns of doubles, which zstd then makes small.

A double's bits are mapped to an unsigned integer in the order of the numbers (a negative one inverted, a
positive one with its sign bit set). What is kept is the difference, modulo 2⁶⁴, between a number and what was
expected of it, as a zigzag integer (2r, or −2r − 1 when negative), byte plane by byte plane: first the lowest
byte of every number, a column after the other, then the next byte. A column that never changes is all zeros.

What is expected, by `Packed.expected`::

    "difference n"    the n-th difference is 0
    "integral"        xₜ = xₜ₋₁ + Δt·vₜ, in doubles; v is the field named in the schema, Δt is `Packed.dt`
    "rotation"        qₜ = (1 + h + h²/2 + h³/6)⊗qₜ₋₁ with h = Δt/2·ωₜ as a pure quaternion

The last two are how the physics engine steps, so that all but a few positions are what is expected, exactly.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from imitate.geometry import Array, read_only

Words = NDArray[np.uint64]
_SIGN = np.uint64(1 << 63)
_ONE = np.uint64(1)
MOST_SURPRISES = 0.2
"""share of numbers off the integral beyond which plain differences are kept instead: they unpack faster."""


@dataclass(frozen=True)
class Packed:
    """Numbers of any shape (N, …), packed along the first axis."""

    shape: tuple[int, ...]
    expected: str
    dt: float
    planes: bytes


def pack(values: Array, order: int) -> Packed:
    """``values`` (N, …) as differences of the given order along the first axis."""
    return Packed(
        values.shape, f"difference {order}", 0.0, _planes(_difference(_words(_flat(values)), order))
    )


def pack_integral(values: Array, rates: Array, dt: float, order: int) -> Packed:
    """``values`` (N, …) expected from their ``rates`` (N, …), or as in `pack` where that fits badly."""
    with np.errstate(all="ignore"):
        x, step = _flat(values), _flat(rates) * dt
        expected = x[:-1] + step[1:]
    if x.size and np.isfinite(x).all() and np.isfinite(expected).all():  # the bits of a NaN are not exact
        words = _words(x)
        words[1:] -= _words(expected)
        if np.count_nonzero(words[1:]) <= MOST_SURPRISES * words.size:
            return Packed(values.shape, "integral", dt, _planes(words))
    return pack(values, order)


def pack_rotations(values: Array, rates: Array, dt: float, order: int) -> Packed:
    """Quaternions (N, K, 4) expected from angular velocities (N, K, 3), or as in `pack` when not finite."""
    with np.errstate(all="ignore"):
        turns = np.moveaxis(_turns(rates, dt)[1:], -1, 0)
        expected = np.stack(_product(turns, np.moveaxis(values[:-1], -1, 0)), axis=-1)
    if not (values.size and np.isfinite(values).all() and np.isfinite(expected).all()):
        return pack(values, order)
    words = _words(values)
    words[1:] -= _words(expected)
    return Packed(values.shape, "rotation", dt, _planes(words.reshape(len(values), -1)))


def unpack(packed: Packed, rates: Array | None = None) -> Array:
    """The numbers, bit for bit; ``rates`` as they were given when packing.

    Raises:
        ValueError: the bytes do not fit the shape or the expectation is unknown.
    """
    count = packed.shape[0]
    words = _unplanes(packed.planes, count, int(np.prod(packed.shape[1:], dtype=np.int64)))
    kind, _, order = packed.expected.partition(" ")
    if kind == "difference":
        for _ in range(int(order)):
            np.add.accumulate(words, axis=0, out=words)
        return read_only(_doubles(words).reshape(packed.shape))
    if rates is None or kind not in ("integral", "rotation"):
        raise ValueError(f"columns of unknown kind {packed.expected!r}")
    if kind == "integral":
        step = _flat(rates) * packed.dt
        columns = [_integrated(words[:, c], step[:, c]) for c in range(words.shape[1])]
        return read_only(np.stack(columns, axis=1).reshape(packed.shape))
    surprises = words.reshape(packed.shape)
    turns = _turns(rates, packed.dt)
    bodies = [_turned(surprises[:, k], turns[:, k]) for k in range(packed.shape[1])]
    return read_only(np.stack(bodies, axis=1).reshape(packed.shape))


def _integrated(surprises: Words, step: Array) -> Array:
    values = np.empty(len(step))
    values[0] = _doubles(surprises[:1])[0]
    known = 0
    for k in (*(np.flatnonzero(surprises[1:]) + 1).tolist(), len(step)):
        run = step[known:k].copy()
        run[0] = values[known]
        values[known:k] = np.add.accumulate(run)  # adds one after the other, as the engine does
        if k < len(step):
            expected = _words(values[k - 1 : k] + step[k : k + 1])
            values[k] = _doubles(expected + surprises[k])[0]
        known = k
    return values


def _turns(rates: Array, dt: float) -> Array:
    """(…, 4) quaternions 1 + h + h²/2 + h³/6: + and × alone, which are the same on every machine."""
    with np.errstate(all="ignore"):
        x, y, z = np.moveaxis(rates * (dt / 2), -1, 0)
        square = -(x * x + y * y + z * z)
        along = 1 + square / 6
        return np.stack([x * along, y * along, z * along, 1 + square / 2], axis=-1)


def _product(a: Any, b: Any) -> tuple[Any, Any, Any, Any]:
    """Hamilton product of x y z w, for numbers and for arrays alike, in the same order of operations."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _turned(surprises: Words, turns: Array) -> Array:
    """One body's quaternions (N, 4), a step at a time."""
    q = tuple(_doubles(surprises[0]).tolist())
    rows = [q]
    for turn, by in zip(turns[1:].tolist(), surprises[1:].view(np.int64).tolist(), strict=True):
        q = _shifted(_product(turn, q), by)
        rows.append(q)
    return np.array(rows)


_DOUBLES, _INTEGERS = struct.Struct("<4d"), struct.Struct("<4q")


def _shifted(values: tuple[float, ...], by: list[int]) -> tuple[float, ...]:
    """The doubles that lie ``by`` places further in the order of the numbers, modulo 2⁶⁴; four of each."""
    a, b, c, d = _INTEGERS.unpack(_DOUBLES.pack(*values))
    i, j, k, n = by
    e = a + i if a >= 0 else a - i
    f = b + j if b >= 0 else b - j
    g = c + k if c >= 0 else c - k
    h = d + n if d >= 0 else d - n
    if ((a ^ e) | (b ^ f) | (c ^ g) | (d ^ h)) >> 63 == 0:  # every sum is a double of the same sign
        return _DOUBLES.unpack(_INTEGERS.pack(e, f, g, h))
    words = _words(np.array(values)) + np.array(by, np.int64).view(np.uint64)
    return tuple(_doubles(words).tolist())


def _flat(values: Array) -> Array:
    return values.reshape(len(values), -1) if values.size else values.reshape(len(values), 0)


def _words(values: Array) -> Words:
    bits = np.ascontiguousarray(values).view(np.uint64)
    words: Words = np.where(bits & _SIGN, ~bits, bits | _SIGN)
    return words


def _doubles(words: Words) -> Array:
    bits: Words = np.where(words & _SIGN, words ^ _SIGN, ~words)
    return bits.view(np.float64)


def _difference(words: Words, order: int) -> Words:
    for _ in range(order):
        words[1:] = words[1:] - words[:-1]
    return words


def _planes(words: Words) -> bytes:
    zigzag = (words << _ONE) ^ (words.view(np.int64) >> np.int64(63)).view(np.uint64)
    planes = np.ascontiguousarray(zigzag.T).astype("<u8", copy=False).view(np.uint8)
    return np.ascontiguousarray(planes.reshape(-1, 8).T).tobytes()


def _unplanes(planes: bytes, count: int, width: int) -> Words:
    if len(planes) != 8 * count * width:
        raise ValueError(f"{len(planes)} bytes for {count} × {width} numbers")
    if not planes:
        return np.zeros((count, width), np.uint64)
    by_number = np.ascontiguousarray(np.frombuffer(planes, np.uint8).reshape(8, -1).T)
    zigzag = by_number.view("<u8").astype(np.uint64, copy=False).reshape(width, count)
    words: Words = (zigzag >> _ONE) ^ (np.uint64(0) - (zigzag & _ONE))
    return np.ascontiguousarray(words.T)
