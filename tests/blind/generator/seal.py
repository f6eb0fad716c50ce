"""Sealed seeds: the SHA-256 of a seed is committed first, the seed itself is opened after the verdicts are stored.

python -m tests.blind.generator.seal new --suite full --out SECRET_FILE     (appends the digest to tests/blind/seals.txt)
"""

import argparse
import hashlib
import secrets
from pathlib import Path

REGISTER = Path(__file__).resolve().parent.parent / "seals.txt"


def digest(seed):
    """SHA-256 (hex) of the seed written in decimal."""
    return hashlib.sha256(str(int(seed)).encode("ascii")).hexdigest()


def sealed(seed, register=REGISTER):
    """Name of the suite that was sealed with this seed, None where its digest stands in no line of the register."""
    if not Path(register).exists():
        return None
    for line in Path(register).read_text(encoding="utf-8").splitlines():
        fields = line.split()
        if len(fields) >= 2 and fields[0] == digest(seed):
            return fields[1]
    return None


def new(suite, out, register=REGISTER):
    """Draw a secret seed, write it to `out`, append its digest to the register; return the digest."""
    seed = secrets.randbits(62)
    Path(out).write_text(f"{seed}\n", encoding="ascii")
    with open(register, "a", encoding="utf-8") as file:
        file.write(f"{digest(seed)} {suite}\n")
    return digest(seed)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("action", choices=["new"])
    parser.add_argument("--suite", default="full")
    parser.add_argument("--out", required=True, help="where the secret seed goes; keep it out of the repository")
    arguments = parser.parse_args()
    print(new(arguments.suite, arguments.out))
