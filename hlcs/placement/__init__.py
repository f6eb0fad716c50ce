"""Placement tests: units on a grid, layer by layer, measured with plates, beside what laboratories measured."""
