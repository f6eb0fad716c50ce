"""Solids: spheres, boxes and other primitives, convex pieces and their compounds, meshes from files."""
