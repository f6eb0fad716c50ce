"""Motion: free motion, the constraints of contact, impacts, and the step in time."""
