"""What is found on a few recordings, confirmed on more of them."""

from types import SimpleNamespace

from hlcs.kinds.trajectories.experiment import numbers_found


def test_sets_are_fitted_to_more_recordings_from_the_numbers_that_were_found_on_few():
    """A number that the few do not show is where it is expected; that nothing is missing tells no place to begin."""
    laws = [
        SimpleNamespace(name="restitution", expected={"coefficient": 0.5}),
        SimpleNamespace(name="velocity_dependent_restitution", expected={"exponent": 0.0, "threshold": 0.01}),
    ]
    both = {"restitution": {"coefficient": 0.87}, "velocity_dependent_restitution": {"exponent": 0.05, "threshold": None}}
    sets = (
        {"effects": ["restitution", "velocity_dependent_restitution"], "parameters": both},
        {"effects": [], "parameters": {}},
        {"effects": ["restitution"], "parameters": {"restitution": {"coefficient": 0.8}}},
    )
    assert numbers_found(SimpleNamespace(sets=sets), laws) == [
        {"restitution": {"coefficient": 0.87}, "velocity_dependent_restitution": {"exponent": 0.05, "threshold": 0.01}},
        {"restitution": {"coefficient": 0.8}},
    ]
