"""What is read of a file that a user names: its bytes within a bound, or one line that says why not."""

import os

import pytest

from minibullet.errors import InputError
from minibullet.files.reading import read_bytes, read_text


def read(path, most=100):
    return read_bytes(path, f"file '{path}'", most, "thin it out")


def test_a_file_within_the_bound_is_read_whole(tmp_path):
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(range(100)))
    assert read(path) == bytes(range(100))


@pytest.mark.parametrize("kind", ["folder", "device", "pipe", "missing", "long name", "zero byte", "large", "endless link"])
def test_what_is_no_bounded_regular_file_is_refused_at_once(tmp_path, kind):
    path = tmp_path / "a"
    if kind == "folder":
        path.mkdir()
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "long name":
        path = tmp_path / ("a" * 300)
    elif kind == "zero byte":
        path = str(path) + "\0"
    elif kind == "large":
        path.write_bytes(bytes(101))
    elif kind == "endless link":
        path.symlink_to(path)
    with pytest.raises(InputError) as refusal:
        read(path)
    assert "\n" not in str(refusal.value) and ("at most" in str(refusal.value)) == (kind == "large")


@pytest.mark.parametrize(("content", "said"), [(b"\xff\xfe\x00a", "not text"), (b"a\nb\0c", "line 2: a zero byte")])
def test_bytes_that_are_no_text_are_refused(tmp_path, content, said):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(InputError, match=said):
        read_text(path, "a.txt", 100, "")


def test_the_mark_before_the_text_is_left_out(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes("\ufeffµ".encode())
    assert read_text(path, "a.txt", 100, "") == "µ"
