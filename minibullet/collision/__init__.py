"""From bodies to contacts: candidate pairs, separating directions, normals and gaps, points on faces."""
