"""Islands: groups of bodies linked through contacts. Each can be solved by itself."""

import numpy as np

from minibullet.kernels import kernel, leaf


@leaf
def root_of(body, parent):
    """The body that stands for the island of ``body``; the way to it is made shorter, in ``parent`` (n,)."""
    while parent[body] != body:
        parent[body] = parent[parent[body]]
        body = parent[body]
    return body


@kernel
def find_islands(bodies, moving):
    """Contacts sorted by island, stable, and where each island begins: bodies linked through contacts; fixed bodies do not
    link."""
    parent = np.arange(len(moving))
    for c in range(len(bodies)):
        if moving[bodies[c, 0]] and moving[bodies[c, 1]]:
            a, b = root_of(bodies[c, 0], parent), root_of(bodies[c, 1], parent)
            parent[max(a, b)] = min(a, b)
    label, count = np.empty(len(bodies), dtype=np.int64), np.zeros(len(moving) + 1, dtype=np.int64)
    for c in range(len(bodies)):
        label[c] = root_of(bodies[c, 0] if moving[bodies[c, 0]] else bodies[c, 1], parent)
        count[label[c] + 1] += 1
    # sorted by counting: where each label's contacts begin, then every contact to its place
    islands, filled = np.empty(len(bodies) + 1, dtype=np.int64), 0
    for a in range(len(moving)):
        if count[a + 1] > 0:
            islands[filled] = count[a]
            filled += 1
        count[a + 1] += count[a]
    islands[filled] = len(bodies)
    order = np.empty(len(bodies), dtype=np.int64)
    for c in range(len(bodies)):
        order[count[label[c]]] = c
        count[label[c]] += 1
    return order, islands[: filled + 1]
