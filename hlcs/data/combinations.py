"""What an experiment file says twice, or of one recording alone: each key is right, and together they make little sense."""

from minibullet.errors import shown


def check_combinations(file):
    """Refuse an effect that stands twice in the model of an ExperimentFile; tell of what changes nothing but is hardly meant."""
    if name := twice(entry["name"] for entry in file.effects):
        file.source.fail("effects", f"'{shown(name)}' stands there twice: write it once, with the numbers that hold", "model")
    if name := twice(file.candidates or ()):
        file.source.warn("candidates", f"'{shown(name)}' stands there twice: once says the same", "diagnose")
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


def twice(names):
    """The first of the names that stands there again; None where none does."""
    seen = set()
    return next((name for name in names if name in seen or seen.add(name)), None)
