"""Numbers and a text as one piece of bytes with its digest: what checkpoints and journals are made of.

Layout, little endian: int64 length of the text; the text, JSON, with names, kinds and shapes of the arrays; the arrays
one after the other; 16 bytes of the BLAKE2b digest of all before.
"""

from __future__ import annotations

import hashlib
import json
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

DIGEST = 16
KINDS = ("<f8", "|u1", "<i8")


def digest(data: bytes) -> bytes:
    """BLAKE2b of 16 bytes."""
    return hashlib.blake2b(data, digest_size=DIGEST).digest()


def packed(text: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """The bytes of a text that JSON can hold, and of arrays by name."""
    return b"".join(packed_pieces(text, arrays))


def packed_pieces(text: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> list[bytes | memoryview]:
    """The same as what follows one another, without a copy of the arrays: they must not change until it is written."""
    numbers = {name: _plain(array) for name, array in arrays.items()}
    shapes = [[name, array.dtype.str, list(array.shape)] for name, array in numbers.items()]
    head = json.dumps({"text": text, "arrays": shapes}).encode()
    views = [memoryview(array).cast("B") for array in numbers.values() if array.size]
    pieces: list[bytes | memoryview] = [struct.pack("<q", len(head)), head, *views]
    whole = hashlib.blake2b(digest_size=DIGEST)
    for piece in pieces:
        whole.update(piece)
    return [*pieces, whole.digest()]


def unpacked(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Text and arrays; ValueError where a byte has changed or is missing."""
    body, end = data[:-DIGEST], data[-DIGEST:]
    if len(data) < DIGEST + 8 or digest(body) != end:
        raise ValueError("its checksum does not fit")
    length = struct.unpack("<q", body[:8])[0]
    head, at, arrays = json.loads(body[8 : 8 + length]), 8 + length, {}
    for name, kind, shape in head["arrays"]:
        if kind not in KINDS:
            raise ValueError(f"it holds numbers of the kind {kind}")
        count = int(np.prod(shape, dtype=int))
        arrays[name] = np.frombuffer(body, kind, count, at).reshape(shape).copy()
        at += arrays[name].nbytes
    return head["text"], arrays


def _plain(array: np.ndarray) -> np.ndarray:
    array = np.asarray(array)
    kind = "|u1" if array.dtype == np.uint8 else "<i8" if array.dtype.kind in "iu" else "<f8"
    return np.ascontiguousarray(array, dtype=kind)
