"""The lowest versions that pyproject.toml allows, one requirement a line, for pip: `python3 tests/reliability/lowest.py test`.

Arguments: the extras to take beside the dependencies. What has no floor is printed as it stands. Needs Python and nothing else.
"""

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2] / "pyproject.toml"


def lowest(*extras):
    """The requirements of the project and of these extras, every floor `>=` made an exact `==`: a list of texts."""
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *(one for extra in extras for one in project["optional-dependencies"][extra])]
    return [re.sub(r">=([^,;\s]+)", r"==\1", one) for one in wanted]


if __name__ == "__main__":
    print("\n".join(lowest(*sys.argv[1:])))
