"""What `import hlcs` offers."""

import hlcs


def test_the_package_shows_what_users_need():
    shown = [name for name in dir(hlcs) if not name.startswith("_")]
    assert set(hlcs.__all__) <= set(shown) <= {*hlcs.__all__, "course", "effects", "mystery"}
    assert all(getattr(hlcs, name) is not None for name in shown)
