"""What may be missing from a model: effects of the engine, and changes of body, ground, measurement and numerics."""

from hlcs.effects.candidates import Candidate, Free, build, candidate
from hlcs.effects.library import (
    as_stated,
    build_entry,
    check_names,
    class_named,
    classes,
    entry_of,
    own_classes,
    wanted,
    with_own,
)
