"""The seed of a judging deck is the SHA-256 of the frozen commit: who writes the analyst cannot choose it, anyone can check it.

Every judging deck whose answers are opened is reported: the scorer adds it to tests/blind/opened.txt (commit, cases), and the
first one counts. A deck of another seed judges nothing.
"""

import hashlib
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
REGISTER = ROOT / "tests" / "blind" / "opened.txt"


def seed_of(commit):
    """The seed that belongs to a commit: the first 15 hexadecimal digits of the SHA-256 of its name (fits any integer type)."""
    return int(hashlib.sha256(commit.encode("ascii")).hexdigest()[:15], 16)


def frozen(root=ROOT):
    """The commit of a clean working tree; SystemExit where anything is not committed."""
    changed = _git(root, "status", "--porcelain")
    if changed:
        raise SystemExit(
            f"{root}: not committed:\n{changed}\na judging deck needs a frozen commit; commit or put away these files"
        )
    return _git(root, "rev-parse", "HEAD")


def commit_of(root):
    """The commit that a checkout stands at, "+" after it where files differ from it; "unknown" of a folder that is none."""
    try:
        return _git(root, "rev-parse", "HEAD") + ("+" if _git(root, "status", "--porcelain") else "")
    except subprocess.CalledProcessError:
        return "unknown"


def judges(record):
    """Whether the record of a deck is that of a judging deck: whole, and its seed that of its commit."""
    return (
        bool(record.get("commit")) and record["seed"] == seed_of(record["commit"]) and not record["family"] and not record["kind"]
    )


def opened(record=None, register=REGISTER):
    """Lines of all judging decks opened so far, oldest first; a record's deck is added where it is not among them."""
    lines = register.read_text(encoding="utf-8").splitlines() if register.exists() else []
    if record is not None and judges(record):
        line = f"{record['commit']} {len(record['cases'])}"
        if line not in lines:
            lines.append(line)
            register.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return lines


def _git(root, *words):
    return subprocess.run(["git", "-C", str(root), *words], capture_output=True, text=True, check=True).stdout.strip()
