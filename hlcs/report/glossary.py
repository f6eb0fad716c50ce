"""The words of reports, explained once: pages of results carry what they use, the documentation carries all."""

GLOSSARY = {
    "90 % interval": "A range that holds the true number nine times in ten, if the model is right. 0.46 +- 0.01 stands for "
    "0.45 to 0.47.",
    "adequate": "A model is adequate where its residuals cannot be told from noise: neither their size nor any pattern in them.",
    "bias": "The mean of model - measured. Positive: the model reads more than was measured.",
    "chi-square per degree of freedom": "The mean square of the residuals in units of the noise, counted per observation that no "
    "fitted number has used up. 1 is what noise alone leaves; 4 is a misfit of twice the noise.",
    "complete": "The verdict that nothing is missing at the precision of these data.",
    "draws": "Noise drawn by the computer, many times, to see what noise alone would show. Of 600 draws no probability below 1 "
    "in 601 can be read.",
    "evidence": "By how much -2 log of the probability of the model falls with an effect, all that it costs counted. Above 0 it "
    "helps.",
    "fitted": "The fitted error is that on the recordings that the numbers were fitted to. It falls with every "
    "number that is added, needed or not.",
    "foreseen": "Computed from the slopes of the model under test, not from a fit: a first look, good for what is small.",
    "held out": "The held-out error is that on recordings that the numbers were not fitted to. Only what is really there "
    "makes it fall.",
    "noise": "How far two readings of the same thing differ: one standard deviation of one reading, also called sigma.",
    "p": "The probability that noise alone shows a misfit as large as this one.",
    "residual": "Of data: measured - model; above zero the model is too low. Of a step of the engine: by how much its impulses "
    "miss the contact law.",
    "rms": "Root mean square, the usual size of an error: the root of the mean of its squares.",
    "starts": "Position and velocity at the first sample. What the file does not state of them is fitted and takes up a share of "
    "the noise, so that a perfect model misses by a little less than the noise.",
    "unexplained": "The verdict that the model fails, and that no effect of the library, nor a few of them, leaves noise alone.",
    "withheld": "Of a number: these data cannot give it honestly.",
}


# words of the documentation beside those of reports
OTHERS = {
    "ambiguous": "The verdict that something is missing, and that these data cannot tell which of several effects it is.",
    "armour unit": "A block of concrete that is laid, with many others, to protect a shore or a breakwater from waves.",
    "campaign": "Tests made together, by the same people on the same bed. What is off in one campaign is off in all of "
    "its tests.",
    "candidate": "An effect that a diagnosis tries.",
    "cannot judge": "The verdict that the noise is unknown: nobody can say whether a misfit is one.",
    "channel": "One kind of reading in a recording: x, y or z of the position, rx, ry or rz of the orientation.",
    "certificate": "What each step of the engine publishes of itself: by how much its impulses miss the contact law, "
    "relative to the velocities, with the contact where they miss it most. Below the tolerance the step counts as solved.",
    "coefficient of variation, CV": "The standard deviation between tests over their mean.",
    "bed": "What the first layer stands on: flat, a slope, a mound, or a survey.",
    "crest": "The top of the structure; its level is the mean of the plates on the last layer, above datum.",
    "datum": "The level z = 0 from which levels are counted.",
    "contact friction": "The friction coefficient of a pair of surfaces. Bullet multiplies one coefficient of each body: "
    "its 0.6 and 0.6 make a contact friction of 0.36.",
    "Cubipod": "An armour unit: a cube with a truncated pyramid on each of its six faces.",
    "effect": "A physical law, an error of the measurement or a shortcut of the model that may be missing from a model. "
    "All of them: {doc}`reference/effects/index`.",
    "experiment file": "A TOML file that says what was dropped, thrown or placed, what was measured, and which model is "
    "under test.",
    "family": "Effects of one origin (physics, placement, measurement, shortcuts of the model): data of layers may tell families "
    "apart where they cannot tell their members apart.",
    "falling distance": "How far above the units below it a unit is let go, in nominal diameters.",
    "group": "Recordings that are held out together, because they may share what is wrong with them: a day, a film.",
    "hull": "The convex hull of a unit, a simpler body that fills its hollows. Units of hulls cannot interlock.",
    "identifiable": "A number is identifiable where the data tell its value, whatever the others are; an effect, where no "
    "other explains the same data.",
    "Holm's correction": "Makes the p of each of several tests larger: among many tests one p is small by chance.",
    "inclusion": "Weight, 0 to 1, of all fitted sets of effects that hold this effect.",
    "layer coefficient": "Thickness of a layer over the nominal diameter, k. The sum over the layers is the height of the "
    "structure.",
    "lost": "A unit is lost where it fell out of its layer, onto a lower layer or onto the bed.",
    "low-crested structure": "A breakwater whose top lies near the level of the water; homogeneous (HLCS) where it is made of "
    "one kind of unit throughout.",
    "mean relative error, eps_R": "Mean over the layers of the difference between model and measurement, without its sign, over "
    "what was measured.",
    "misplaced": "A unit is misplaced where it came to rest more than half a nominal diameter from its aim, seen from above.",
    "margin": "A layer round each body that contacts keep open, as some engines have it.",
    "model under test": "What is believed to happen: gravity, and the effects under [model] of the experiment file.",
    "nominal diameter, Dn": "Edge of the cube that has the volume of the unit.",
    "null value": "Value of a number at which its effect is exactly absent.",
    "packing density": "Units of a layer per square of the nominal diameter in plan, 1/(a b) of the spacings of the grid.",
    "pilot": "A few recordings, or rows of a table, from which a plan reads how many more are needed.",
    "plate": "A square measuring plate, 2 nominal diameters wide, that is laid on a layer to read its height; nine on each "
    "layer. A plate that the layer alone does not carry at rest is left out.",
    "power": "The probability that an effect of a given size is found.",
    "noncentrality": "By how much chi-square is expected to fall when an effect that is there is added: the sum of squares of "
    'what the effect changes, less what unknown starts take up, in units of the noise. Plans print its root, "over the noise".',
    "placing density": "Units of a layer per square metre.",
    "plausible range": "Where a number is expected to lie. A belief and not a wall: a number beyond it is told as such.",
    "porosity": "Share of the structure that is not concrete.",
    "prior": "What is believed of a number before the data are seen.",
    "recording": "One motion that was measured: one CSV file.",
    "replicates": "Tests with the same inputs. Their scatter is the noise.",
    "restitution": "Normal speed after an impact over that before it.",
    "RPG, TPG": "Rectangular and triangular placement grid.",
    "seed": "The number that all chance in a run is drawn from. The same settings and the same seed give the same run.",
    "signature": "What an effect changes in the readings, in units of the noise. Two effects whose signatures are alike cannot "
    "be told apart.",
    "sigma": "One standard deviation. A residual of 3 sigma is three times what noise makes as a rule.",
    "unsettled": "A unit is unsettled where it still moved, or nothing carried it, when its layer was fixed.",
    "Welch's test, z": "Compares two means that scatter differently. z is their difference over its standard error.",
    "verdict": "The answer of a diagnosis: complete, effect, ambiguous, unexplained or cannot judge.",
}


def used_in(text):
    """{word: explanation} of the words that a text uses."""
    lower = text.lower()
    return {word: told for word, told in GLOSSARY.items() if ("p = " if word == "p" else word) in lower}


def as_markdown():
    """The page of the documentation."""
    lines = [
        "# Glossary",
        "",
        "What reports and these pages say, in a sentence each. Names, symbols and signs: {doc}`conventions`.",
        "",
    ]
    for word, told in sorted((GLOSSARY | OTHERS).items(), key=lambda entry: entry[0].lower()):
        lines += [word, f": {told}", ""]
    return "\n".join(lines)
