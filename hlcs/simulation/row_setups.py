"""The body and surroundings of each row of an outcome table: the file's, with what the row itself states."""

from dataclasses import replace

from hlcs.data.quantities import ROW_KEYS
from hlcs.effects.contract import Setup


def row_setup(file, inputs, row):
    """The Setup of one row: the file's, with what the row itself states."""
    parts = {"body": file.body, "surroundings": file.surroundings}
    for column, (part, key) in ROW_KEYS.items():
        if column in inputs:
            parts[part] = replace(parts[part], **{key: float(inputs[column][row])})
    return Setup(parts["body"], parts["surroundings"])


def row_setups(file, table):
    """The Setup of each row of an OutcomeTable, a list."""
    return [row_setup(file, table.inputs, row) for row in range(len(table.values))]
