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
    "fitted": "An error is fitted where it is of the recordings that the numbers were fitted to. Such an error falls with every "
    "number that is added, needed or not.",
    "foreseen": "Computed from the slopes of the model under test, not from a fit: a first look, good for what is small.",
    "held out": "An error is held out where it is of recordings that the numbers were not fitted to. Only what is really there "
    "makes it fall.",
    "noise": "How far two readings of the same thing differ: one standard deviation of one reading, also called sigma.",
    "p": "The probability that noise alone shows a misfit as large as this one.",
    "residual": "Measured - model. Above zero: the model is too low.",
    "rms": "Root mean square, the usual size of an error: the root of the mean of its squares.",
    "starts": "Position and velocity at the first sample. What the file does not state of them is fitted and takes up a share of "
    "the noise, so that a perfect model misses by a little less than the noise.",
    "unexplained": "The verdict that the model fails, and that no effect of the library, nor a few of them, leaves noise alone.",
    "withheld": "Of a number: these data cannot give it honestly.",
}


def used_in(text):
    """{word: explanation} of the words that a text uses."""
    lower = text.lower()
    return {word: told for word, told in GLOSSARY.items() if ("p = " if word == "p" else word) in lower}


def as_markdown():
    """The page of the documentation."""
    lines = ["# Words of reports", "", "What `compare` and `diagnose` print. Names, symbols and signs: {doc}`conventions`.", ""]
    for word, told in GLOSSARY.items():
        lines += [word, f": {told}", ""]
    return "\n".join(lines)
