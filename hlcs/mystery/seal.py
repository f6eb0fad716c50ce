"""An answer out of sight: base64 of JSON. It is no secret; it only keeps an eye from falling on it."""

import base64
import json

SEALED = "answer.sealed"  # the file of a data set that holds its answer


def sealed(answer):
    """The text of a sealed answer; answer: a dictionary that JSON can hold."""
    return base64.encodebytes(json.dumps(answer, sort_keys=True).encode("utf-8")).decode("ascii")


def opened(data):
    """The answer that was sealed; data: bytes."""
    return json.loads(base64.b64decode(data))
