"""Files are replaced whole: links are followed, and what is no regular file stays."""

import os

import pytest

from minibullet.errors import InputError
from minibullet.files.writing import replace_file, whole


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_what_is_no_regular_file_is_not_replaced_by_one(tmp_path):
    """A rename puts a file in the place of a pipe or, for the superuser, of a device such as /dev/null."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    (tmp_path / "link").symlink_to(pipe)
    for name in (pipe, tmp_path / "link"):
        with pytest.raises(OSError, match="no regular file"), whole(name) as partial:
            partial.write_bytes(b"new")
        with pytest.raises(InputError, match="cannot be saved"):
            replace_file(name, b"new")
    assert pipe.is_fifo() and (tmp_path / "link").is_symlink() and len(list(tmp_path.iterdir())) == 2


def test_a_link_is_followed_as_by_every_program(tmp_path):
    (tmp_path / "there").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "there")
    replace_file(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "there").read_bytes() == b"new"


@pytest.mark.parametrize("name", ["", ".", "a\0b"])
def test_names_that_no_file_has_are_input_errors(name):
    with pytest.raises(InputError, match="cannot be saved"):
        replace_file(name, b"new")
