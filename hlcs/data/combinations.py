"""What an experiment file says twice, or of one recording alone: each key is right, and together they make little sense."""

from hlcs.data.rigid_body import borne
from minibullet.effects.fluid import AIR_DENSITY
from minibullet.errors import shown

OF_FLUIDS = (  # what is stated of a liquid, in words, its unit, and the effects that find one number for it
    ("fluid_viscosity", "viscosities", "Pa s", ("sphere_drag", "stokes_drag")),
    ("fluid_density", "liquid densities", "kg/m3", ("buoyancy",)),
    ("tube_radius", "tubes", "m radius", ("tube_drag",)),
)


def check_combinations(file):
    """Refuse an effect that stands twice in the model of an ExperimentFile; tell of what changes nothing but is hardly meant."""
    if name := twice(entry["name"] for entry in file.effects):
        file.source.fail("effects", f"'{shown(name)}' stands there twice: write it once, with the numbers that hold", "model")
    if name := twice(file.candidates or ()):
        file.source.warn("candidates", f"'{shown(name)}' stands there twice: once says the same", "diagnose")
    for index, each in ((None, file), *enumerate(file.trials)):
        if told := too_narrow(each.body, each.surroundings):
            file.source.fail("tube_radius", told, "surroundings" if index is None else "trial", index)
    with_session = [index for index, trial in enumerate(file.trials) if trial.session]
    if 0 < len(with_session) < len(file.trials):
        without = next(index for index, trial in enumerate(file.trials) if not trial.session)
        several = len({file.trials[index].session for index in with_session}) > 1
        why = "clock, scale and lean are taken to be right there" if several else "one session alone changes nothing"
        what = (
            f"stands in {len(with_session)} of {len(file.trials)} trials, and trial {without + 1} has none: {why}; state it of "
            "all, or of none"
        )
        file.source.warn("session", what, "trial", with_session[0])


def too_narrow(body, surroundings):
    """What is wrong with a tube that a sphere does not fit into; "" where it does, or none is stated."""
    tube, ball = surroundings.tube_radius, body.radius if body.shape == "sphere" else None
    if not tube or not ball or ball < tube:
        return ""
    return (
        f"{tube:g} m, and the body has a radius of {ball:g} m: it does not fit in; state half the inner width of the tube, in m"
    )


def fluids_told(file, moved):
    """Notes on a fluid that is not stated, of bodies so light that it carries much of their weight, and on liquids that differ
    from one recording or row to another, where an effect would find one number for all of them.

    moved: the trials or the setups of rows, each with its body and its surroundings.
    """
    around, notes, stated = [each.surroundings for each in moved], [], {entry["name"] for entry in file.effects}
    if any(not each.surroundings.fluid_stated and borne(each.body, each.surroundings) for each in moved):
        air = f"fluid_density = {AIR_DENSITY:g}"
        notes.append(
            f"no fluid is stated, and so light a body is taken to be in air; write {air}, or what it is, in [surroundings]"
        )
    for key, what, unit, names in OF_FLUIDS:
        values = {getattr(each, key) for each in around if each.in_liquid} - {0.0}
        if len(values) > 1 and stated.isdisjoint(names):
            notes.append(
                f"{what} of {min(values):g} to {max(values):g} {unit} are stated, and {' or '.join(names)} finds one for all: "
                f'to take each as it is stated, write {{ name = "{names[0]}" }} without a number in [model] effects'
            )
    return tuple(notes)


def twice(names):
    """The first of the names that stands there again; None where none does."""
    seen = set()
    return next((name for name in names if name in seen or seen.add(name)), None)
