"""The command `hlcs`."""
