"""The numbers that define how a World computes; a frozen value."""

from dataclasses import dataclass, fields

from minibullet.errors import InputError, is_number, one_of, shown_value
from minibullet.values import Value

MOST_ITERATIONS = 1_000_000  # sweeps of one step: ten thousand times the default [-]
SOLVERS = ("exact", "gauss_seidel", "sequential_impulse")


@dataclass(frozen=True)
class Settings(Value):
    """How a World computes. Raises InputError that names the field, its value and the rule.

    time_step [s]; friction, restitution: of a contact where the bodies say nothing else [-]; margin: layer around every body
    that its contacts keep open, so two bodies rest two margins apart [m]; linear_damping, angular_damping: share d of a
    velocity that is lost [-]; damping_law: "bullet" (v (1-d)^dt) or "per_step" (v (1-d), equation 6 as printed); solver "exact"
    (Gauss-Seidel, then Newton where it stalls), "gauss_seidel" (never more than ``iterations`` sweeps) or "sequential_impulse"
    (Bullet's way); iterations: most sweeps a step; tolerance: relative residual at which a step counts as solved [-].
    """

    time_step: float = 1.0 / 240.0
    friction: float = 0.5
    restitution: float = 0.0
    margin: float = 0.0
    linear_damping: float = 0.0
    angular_damping: float = 0.0
    damping_law: str = "bullet"
    solver: str = "exact"
    iterations: int = 100
    tolerance: float = 1e-8

    _units = {"time_step": "s", "margin": "m"}
    _told = ("time_step", "friction", "restitution", "solver")

    def __post_init__(self):
        rules = {
            "time_step": (lambda v: v > 0, "must be > 0 (seconds; 1/240 is usual)"),
            "friction": (lambda v: v >= 0, "must be >= 0"),
            "restitution": (lambda v: 0 <= v <= 1, "must lie between 0 and 1"),
            "margin": (lambda v: v >= 0, "must be >= 0 (metres)"),
            "linear_damping": (lambda v: 0 <= v <= 1, "must lie between 0 and 1"),
            "angular_damping": (lambda v: 0 <= v <= 1, "must lie between 0 and 1"),
            "iterations": (
                lambda v: 1 <= v <= MOST_ITERATIONS and v == int(v),
                f"must be a whole number >= 1, at most {MOST_ITERATIONS}",
            ),
            "tolerance": (lambda v: v > 0, "must be > 0"),
        }
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name in rules:
                rule, words = rules[field.name]
                if not isinstance(value, (int, float)) or not is_number(value) or not rule(value):
                    raise InputError(f"settings: {field.name} = {shown_value(value)}; it {words}")
                # kernels are compiled for types: 1 where 1.0 is meant would compile them all again
                object.__setattr__(self, field.name, type(field.default)(value))
        for name, allowed in (("damping_law", ("bullet", "per_step")), ("solver", SOLVERS)):
            if getattr(self, name) not in allowed:
                value = getattr(self, name)
                raise InputError(f"settings: {name} = {shown_value(value)}; {one_of(value, allowed)}")
