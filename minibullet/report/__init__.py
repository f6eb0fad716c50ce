"""What a step and a run tell: energy and momentum, a log, pictures."""
