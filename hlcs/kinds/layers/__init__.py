"""Tables of layer coefficients beside simulated placement tests."""
