"""Files that are whole or not there, and files of arrays with a description."""

from __future__ import annotations

import json
import os
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray


@contextmanager
def whole_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for writing that takes the place of ``path`` once it is complete; until then the old one stays."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            yield file
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)  # as open() would have made it: mkstemp lets only its owner read
        temporary.replace(path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def write_npz(path: str | Path, meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], *, compress: bool) -> Path:
    """Write arrays and a description to an npz file; an older file of that name stays whole until the new one is."""
    path = Path(path)
    with whole_file(path) as file:
        save: Callable[..., None] = np.savez_compressed if compress else np.savez
        save(file, meta=np.array(json.dumps(meta)), **arrays)
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
