"""What hangs together: the connected components of a graph."""

from __future__ import annotations

import numpy as np

from perfqr_cad.geometry.arrays import Indices


def components(pairs: Indices, count: int) -> Indices:
    """(count,) the component of each node, numbered from 0 in the order of their first nodes.

    pairs  (k, 2) linked nodes

    >>> components(np.array([[0, 2], [3, 4]]), 5).tolist()
    [0, 1, 0, 2, 2]
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(pairs), np.int8), tuple(pairs.T)), shape=(count, count))
    return connected_components(graph, directed=False)[1].astype(np.int64)
