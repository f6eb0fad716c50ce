"""What stands in a world: bodies and their shapes as packed arrays, kept, checked, saved and loaded."""
