"""Motion of one body as a model has it: flight, contact, many starts at once."""
