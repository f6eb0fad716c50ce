"""Files that appear whole or not at all, whatever happens while they are written."""

import os
import secrets
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path):
    """A name beside `path` to write to: it becomes `path` when the block ends well, and is gone when not. Raises OSError."""
    target = Path(path)
    partial = target.with_name(f".{target.name}.{secrets.token_hex(4)}.partial")
    try:
        yield partial
        with open(partial, "rb+") as file:
            os.fsync(file.fileno())  # on disk before the name points at it
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)
