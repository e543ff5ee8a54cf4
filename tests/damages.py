"""Damage done to files at random, and forged seals that let it through to what lies behind them."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from floquetrod._util import sealed_files


def damaged(whole: bytes, others: Sequence[bytes], rng: np.random.Generator) -> bytes:
    """Return the bytes of a file after one to three accidents; ``others`` are files it may be mixed up with."""
    result = whole
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(result) + 1))
        end = min(len(result), at + int(rng.integers(1, 200)))
        before, hit, after = result[:at], result[at:end], result[end:]
        other, noise = others[int(rng.integers(len(others)))], rng.bytes(end - at)
        accidents = [
            before + bytes(byte ^ 1 << int(rng.integers(8)) for byte in hit[:1]) + hit[1:] + after,
            before + bytes(len(hit)) + after,
            before + noise + after,
            before + noise + hit + after,
            before + before + hit + after,
            before + after,
            before,
            result + noise,
            result + other,
            before + other[at:],
        ]
        result = accidents[int(rng.integers(len(accidents)))]
    return result


def shuffled(whole: bytes, others: Sequence[bytes], rng: np.random.Generator) -> bytes:
    """Return an archive in which members were swapped, left out, doubled, emptied or taken from another file."""
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
        comment = archive.comment
    with zipfile.ZipFile(io.BytesIO(others[int(rng.integers(len(others)))])) as archive:
        foreign = {name: archive.read(name) for name in archive.namelist()}
    names, change = list(members), int(rng.integers(6))
    one, two = (names[int(i)] for i in rng.choice(len(names), 2, replace=False))
    if change == 0:
        members[one], members[two] = members[two], members[one]
    elif change == 1:
        del members[one]
    elif change == 2:
        members[one] = b""
    elif change == 3:
        members |= foreign
    elif change == 4:
        members[one] = foreign[list(foreign)[int(rng.integers(len(foreign)))]]
    else:
        members[one] = damaged(members[one], list(foreign.values()), rng)
    result = io.BytesIO()
    with zipfile.ZipFile(result, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = comment
        for name, content in members.items():
            archive.writestr(name, content)
    return result.getvalue()


def sealed(content: bytes) -> bytes:
    """Return the same bytes with the seal that belongs to them: no accident, somebody did that on purpose."""
    return content[: -sealed_files._SEALED] + sealed_files._seal(io.BytesIO(content))


def unpacked(path: Path) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return description and arrays of a file of ours as numpy reads it, to be written again with changes."""
    with np.load(path, allow_pickle=False) as file:
        arrays = dict(file)
    return json.loads(str(arrays.pop("meta"))), arrays
