"""The kinds of measurement: recordings of motion, tables of outcomes, tables of layers."""
