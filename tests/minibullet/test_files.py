"""What is read of a file that a user names: its bytes within a bound, or one line that says why not."""

import os

import pytest

from minibullet.errors import InputError, shown
from minibullet.files.reading import read_bytes, read_text
from minibullet.files.writing import replace_file, whole


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


@pytest.mark.parametrize("content", [b"\xff\xfe\x00a", b"a\0b"])
def test_bytes_that_are_no_text_are_refused(tmp_path, content):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not text"):
        read_text(path, "a.txt", 100, "")


def test_the_mark_before_the_text_is_left_out(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes("\ufeffµ".encode())
    assert read_text(path, "a.txt", 100, "") == "µ"


@pytest.mark.parametrize("text", ["\x1b[31mred", "a\nb", "\u202eabc", "\x9b2J", "\ud800", "\x07"])
def test_what_is_quoted_of_a_file_gives_a_terminal_nothing_to_obey(text):
    assert shown(text).isprintable() and "\\" in shown(text)


def test_what_is_quoted_is_cut_and_plain_text_stays():
    assert shown("x" * 10**6, 20) == "x" * 20 + ".." and shown("µ = 3 °C") == "µ = 3 °C"


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
