"""Exports of instruments and spreadsheets, read into experiments: `hlcs import`, `hlcs.import_measurements`.

One module reads each format: `tracker`, `phyphox`, `optitrack`, `spreadsheet`; each has `read(path, overrides)`, which returns
what it found and what it assumed, `USES`, the overrides that it listens to, and `NAME`. `experiment` writes.
"""

from hlcs.importing.importer import FORMATS, Imported, import_measurements
