"""Solutions kept on disk by their content: whole, or not there at all."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.spatial.rotation import Array

_FACTS = "facts"


def cache_folder() -> Path | None:
    """Return where this user's solutions are kept, by the platform's convention.

    ``$XDG_CACHE_HOME/stiffkit/links``, or what stands for it; None if there is no such place.
    """
    given = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    if given and Path(given).is_absolute():
        return Path(given) / "stiffkit" / "links"
    try:
        home = Path.home()
    except RuntimeError:
        return None
    caches = home / "Library" / "Caches" if sys.platform == "darwin" else home / ".cache"
    return caches / "stiffkit" / "links"


def load(key: str) -> tuple[dict[str, Any], dict[str, Array]] | None:
    """Return the facts and arrays that were kept under a key; None if there are none, or damaged.

    ``key`` is a hash in hexadecimal.
    """
    folder = cache_folder()
    if folder is None:
        return None
    try:
        path = folder / f"{key}.npz"
        # NumPy leaves a file open whose end is missing.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as kept:
            arrays = {name: kept[name] for name in kept.files}
        facts = json.loads(bytes(arrays.pop(_FACTS)).decode("utf-8"))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return (facts, arrays) if isinstance(facts, dict) else None


def keep(key: str, facts: Mapping[str, Any], arrays: Mapping[str, Array]) -> str:
    """Keep facts (plain values) and arrays under a key; return why not if that is not possible.

    They appear under it only when all is written.
    """
    folder = cache_folder()
    if folder is None:
        return "there is no cache directory; set XDG_CACHE_HOME"
    text = np.frombuffer(json.dumps(dict(facts), allow_nan=False).encode("utf-8"), dtype=np.uint8)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=folder, prefix=f".{key[:16]}.", suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez_compressed(file, **{_FACTS: text}, **arrays)  # type: ignore[arg-type]
                file.flush()
                os.fsync(file.fileno())
            Path(name).replace(folder / f"{key}.npz")
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        return f"{folder} cannot be written: {error.strerror or error}"
    return ""
