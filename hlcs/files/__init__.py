"""Files of users: tables and settings read with their lines, results written whole."""
