"""Files of arrays with a description: replaced whole or not at all, and refused when they are damaged or foreign."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_npz(path: str | Path, meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], *, compress: bool) -> Path:
    """Write arrays and a description to an npz file; an older file of that name stays whole until the new one is."""
    path = Path(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            save: Callable[..., None] = np.savez_compressed if compress else np.savez
            save(file, meta=np.array(json.dumps(meta)), **arrays)
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
    return path


def read_npz(path: str | Path, file_format: str, what: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return description and arrays that `write_npz` wrote with ``meta["format"] == file_format``.

    Raises ValueError, saying that the file is not ``what``, for one that is damaged or foreign.
    """
    path = Path(path)
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        meta = json.loads(str(arrays.pop("meta")))
        if meta["format"] != file_format:
            raise ValueError(f"format {meta['format']!r}, expected {file_format!r}")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, zipfile.BadZipFile, EOFError) as error:
        raise ValueError(f"{path} is not {what} that can be read: {error}") from None
    return meta, arrays
