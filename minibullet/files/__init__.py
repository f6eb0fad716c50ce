"""Files: bounded reading, whole writing, arrays."""
