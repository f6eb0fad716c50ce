"""The library's laws as the generator knows them: parameters, null values, plausible ranges (discovery table; not walls) and
steps for finite differences."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Knob:
    """One parameter. null None = the model's own value (friction, restitution)."""

    name: str
    null: float | None
    low: float
    high: float
    step: float
    scored: bool = True  # False: its exact convention is a choice of the library, so no coverage is asked


LIBRARY = {
    "linear_drag": (Knob("rate", 0, 0, 5, 1e-3),),
    "quadratic_drag": (Knob("drag_coefficient", 0, 0, 2.5, 1e-3),),
    "drag_crisis": (
        Knob("subcritical", 0, 0.2, 1.2, 1e-3),
        Knob("supercritical", 0, 0, 0.5, 1e-3),
        Knob("critical_reynolds", 2e5, 5e4, 5e5, 1e2),
    ),
    "buoyancy": (Knob("fluid_density", 0, 0, 1100, 1e-2),),
    "added_mass": (Knob("coefficient", 0, 0, 1.5, 1e-3),),
    "uniform_flow": (Knob("velocity_x", 0, -3, 3, 1e-3), Knob("velocity_y", 0, -3, 3, 1e-3), Knob("velocity_z", 0, -3, 3, 1e-3)),
    "magnus": (Knob("coefficient", 0, -0.5, 3, 1e-3),),
    "spin_decay": (Knob("rate", 0, 0, 5, 1e-3),),
    "tilted_gravity": (Knob("angle_x", 0, -0.05, 0.05, 1e-5), Knob("angle_y", 0, -0.05, 0.05, 1e-5)),
    "tilted_frame": (Knob("angle_x", 0, -0.05, 0.05, 1e-5), Knob("angle_y", 0, -0.05, 0.05, 1e-5)),
    "length_scale": (Knob("factor", 1, 0.9, 1.1, 1e-5),),
    "time_scale": (Knob("factor", 1, 0.95, 1.05, 1e-5),),
    "clock_offset": (Knob("offset", 0, -0.3, 0.3, 1e-4),),
    "restitution": (Knob("coefficient", None, 0, 1, 1e-4),),
    "velocity_dependent_restitution": (Knob("exponent", 0, 0, 0.3, 1e-4),),
    "friction": (Knob("coefficient", None, 0, 1.5, 1e-4),),
    "stribeck_friction": (Knob("ratio", 1, 1, 2, 1e-3), Knob("speed", 0.2, 0.001, 0.5, 1e-3)),
    "viscous_friction": (Knob("slope", 0, -0.5, 1, 1e-4),),
    "anisotropic_friction": (Knob("ratio", 1, 0.5, 2, 1e-3, False), Knob("angle", 0.0, 0, 3.1416, 1e-3, False)),
    "rolling_friction": (Knob("arm", 0, 0, 0.01, 1e-6),),
    "spinning_friction": (Knob("arm", 0, 0, 0.05, 1e-6),),
    "bottom_slope": (Knob("grade_x", 0, -0.1, 0.1, 1e-5), Knob("grade_y", 0, -0.1, 0.1, 1e-5)),
    "margin_offset": (Knob("offset", 0, 0, 0.02, 1e-6),),
    "size_error": (Knob("relative", 0, -0.02, 0.02, 1e-6),),
    "mass_offset": (Knob("relative", 0, -0.05, 0.05, 1e-5),),
    "inertia_error": (Knob("factor", 1, 0.5, 4, 1e-4, False),),
    "centre_of_mass_offset": (Knob("x", 0, -0.05, 0.05, 1e-6, False), Knob("z", 0, -0.05, 0.05, 1e-6, False)),
}

# reported together because no experiment of one kind parts them (set labels of the discovery page)
LABELS = {
    "effective_gravity": ("buoyancy", "length_scale", "time_scale"),
    "drag_form": ("linear_drag", "quadratic_drag", "drag_crisis"),
    "tilt": ("tilted_gravity", "tilted_frame", "uniform_flow"),
    "rest_height": ("margin_offset", "size_error", "plate_bias", "settlement"),
}

# shortcuts of the analyst's engine that look like these laws and are not simulated here
ALIASES = {
    "linear_drag": ("damping", "drag_crisis"),
    "quadratic_drag": ("drag_crisis", "damping"),
    "spin_decay": ("damping",),
    "spinning_friction": ("damping",),
    "margin_offset": ("plate_bias", "settlement", "slop"),
    "size_error": ("edge_rounding",),
    "static_friction": ("stribeck_friction",),
    "viscous_friction": ("linear_drag",),  # its twin on one load; air gives a block of stated mass and size none that shows
    "restitution": ("contact_compliance", "error_reduction"),
    "velocity_dependent_restitution": ("ground_cushion", "contact_compliance"),
    "rolling_friction": ("damping",),
    "uniform_flow": ("orientation_drag",),
    "friction": ("load_dependent_friction", "friction_combination", "static_friction"),
}


ENDS = {"restitution": 1.0, "added_mass": 1.5}  # no body rebounds faster than it came, none carries so much of a fluid along
ONE_SIDED = ("stribeck_friction",)  # at rest no less than on the way


def plausible(name, law, inputs):
    """Whether all parameters lie within the library's plausible range; that of an arm goes with the radius of the ball."""
    high = {"rolling_friction": 0.1, "spinning_friction": 0.5}.get(name)
    ends = [(knob.low, high * inputs["radius"] if high else knob.high) for knob in LIBRARY[name]]
    return all(low <= law.get(knob.name, knob.null) <= end for knob, (low, end) in zip(LIBRARY[name], ends, strict=True))


def possible(name, law):
    """Whether physics allows the parameters: no negative friction, drag or density, no rebound faster than the impact."""
    return all(
        (law[knob.name] >= knob.low or knob.low < 0 or (knob.null == 1 and name not in ONE_SIDED))
        and law[knob.name] <= ENDS.get(name, float("inf"))
        for knob in LIBRARY[name]
    )


def price(name):
    """Parameters that the library's law has; some matter in no experiment here and are left out above."""
    return {"inertia_error": 3, "centre_of_mass_offset": 3}.get(name, len(LIBRARY[name]))


def nulls(name, setup):
    """Null values of the law's parameters for a setup, {parameter: value}: the model's own where the law is already in it."""
    own = {"coefficient": setup.inputs.get(name, 0.0)} if name in ("friction", "restitution") else setup.base().get(name, {})
    return {knob.name: float(own.get(knob.name, knob.null or 0.0)) for knob in LIBRARY[name]}
