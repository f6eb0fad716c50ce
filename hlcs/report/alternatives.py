"""Sets of effects of which each does as well as the others, in as few words as they need."""

from hlcs.report.words import capital, joined, words


def alternatives(diagnosis):
    """([effects of each set that does as well, without what all of them hold], what all of them hold)."""
    sets = [list(entry["effects"]) for entry in diagnosis.sets]
    common = [name for name in sets[0] if all(name in members for members in sets)]
    return [[name for name in members if name not in common] for members in sets], common


def crossed(choices):
    """Choices, lists of names, with all that may stand in each other's place written once: tuples of tuples of names, one of each
    of which is chosen. Two may where each set that holds one of them is there with the other in its place."""
    sets, groups = {frozenset(choice) for choice in choices}, []

    def alike(a, b):
        pairs = [(members, one, other) for one, other in ((a, b), (b, a)) for members in sets if one in members]
        return all(other not in members and members - {one} | {other} in sets for members, one, other in pairs)

    for name in dict.fromkeys(name for choice in choices for name in choice):
        group = next((group for group in groups if all(alike(name, other) for other in group)), None)
        groups.append([name]) if group is None else group.append(name)
    place = {name: number for number, group in enumerate(groups) for name in group}
    those = dict.fromkeys(tuple(sorted(place[name] for name in choice)) for choice in choices)
    return [tuple(tuple(groups[number]) for number in numbers) for numbers in those]


def crossing_told(those):
    """One tuple of `crossed` in words: "Linear drag or quadratic drag, with tilted frame or tilted gravity"."""
    return capital(", with ".join(joined(map(words, group), "or") for group in those)) + "."
