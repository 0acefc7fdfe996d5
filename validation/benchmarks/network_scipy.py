#!/usr/bin/python3
"""Times SciPy on the networks that benchmark_network writes with --save FOLDER.

    network_scipy.py FOLDER/*.network

Uses SuperLU with both orderings for symmetric matrices. Prints processor seconds of set-up (the matrix) and solve.
"""
import sys
import time

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu


def read(path):
    with open(path, "rb") as file:
        nodes, links, low, high = np.fromfile(file, np.int64, 4)
        return nodes, low, high, np.fromfile(file, [("a", np.int32), ("b", np.int32), ("g", np.float64)], links)


def conductance_matrix(nodes, low, links):
    """Returns the matrix without the grounded node."""
    a, b, g = links["a"], links["b"], links["g"]
    rows, columns = np.concatenate([a, b, a, b]), np.concatenate([a, b, b, a])
    matrix = sparse.csc_matrix((np.concatenate([g, g, -g, -g]), (rows, columns)), (nodes, nodes))
    kept = np.delete(np.arange(nodes), low)
    return matrix[kept][:, kept]


def main():
    print(f"{'':<44}{'set-up':>10}{'solve':>10}{'R':>20}")
    for path in sys.argv[1:]:
        nodes, low, high, links = read(path)
        for ordering in ("MMD_AT_PLUS_A", "COLAMD"):
            start = time.process_time()
            matrix = conductance_matrix(nodes, low, links)
            middle = time.process_time()
            fed = np.zeros(nodes - 1)
            fed[high - (high > low)] = 1
            symmetric = ordering == "MMD_AT_PLUS_A"
            factor = splu(matrix, permc_spec=ordering, options={"SymmetricMode": symmetric}, diag_pivot_thresh=0.0)
            resistance = fed @ factor.solve(fed)
            end = time.process_time()
            name = f"{path.rsplit('/', 1)[-1]} {ordering}"
            print(f"{name:<44}{middle - start:>10.3f}{end - middle:>10.3f}{resistance:>20.14f}", flush=True)


if __name__ == "__main__":
    main()
