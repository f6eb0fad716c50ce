"""Files of users: bounded reading, writing whole or not at all, arrays."""
