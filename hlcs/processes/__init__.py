"""Work in several processes, and its interruption."""
