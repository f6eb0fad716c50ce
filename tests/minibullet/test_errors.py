"""What a message quotes of a user's file."""

import pytest

from minibullet.errors import shown


@pytest.mark.parametrize("text", ["\x1b[31mred", "a\nb", "\u202eabc", "\x9b2J", "\ud800", "\x07"])
def test_what_is_quoted_of_a_file_gives_a_terminal_nothing_to_obey(text):
    assert shown(text).isprintable() and "\\" in shown(text)


def test_what_is_quoted_is_cut_and_plain_text_stays():
    assert shown("x" * 10**6, 20) == "x" * 20 + ".." and shown("µ = 3 °C") == "µ = 3 °C"
