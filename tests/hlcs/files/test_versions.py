"""The versions that a result names."""

import numpy as np

from hlcs.files.versions import versions


def test_versions_name_every_dependency():
    found = versions()
    assert found["numpy"] == np.__version__ and found["python"].startswith("3.") and "python-fcl" in found
