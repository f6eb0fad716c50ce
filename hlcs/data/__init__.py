"""What was measured: experiment files, recordings, outcome tables, impacts; and the checks that they can be right."""
