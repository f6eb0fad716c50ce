"""The contact problem and its solvers: Coulomb's law at one contact, exactly, and at all of them together."""
