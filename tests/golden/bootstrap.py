"""Expected intervals for the cluster bootstrap of aps-metrics, printed to be quoted in its test.

Nested loops over NumPy's own generator, a million replicates in all: nothing in common with the crate but the
definition. SciPy's bootstrap checks the flat case (one map, one link a transmitter). The ends are known to about
three digits; the test allows for that.
"""

import numpy as np
from scipy import stats


def links():
    """Five maps with 3 to 7 transmitters of 1 to 6 links."""
    found = []
    for m in range(5):
        for t in range(3 + m):
            for r in range(1 + (2 * t + m) % 6):
                noise = ((37 * m + 101 * t + 53 * r) % 97) / 97
                found.append((m, t, 0.3 * m * (m - 2) + 0.2 * ((t * t) % 5) + noise))
    return found


def nested(found, replicates, rng):
    maps = {}
    for m, t, value in found:
        maps.setdefault(m, {}).setdefault(t, []).append(value)
    tables = [np.array([[sum(v), len(v)] for v in txs.values()]) for txs in maps.values()]
    means = np.empty(replicates)
    for i in range(replicates):
        total = np.zeros(2)
        for m in rng.integers(len(tables), size=len(tables)):
            table = tables[m]
            total += table[rng.integers(len(table), size=len(table))].sum(axis=0)
        means[i] = total[0] / total[1]
    return means


rng = np.random.default_rng(2026)
found = links()
means = nested(found, 200_000, rng)
low, high = np.quantile(means, [0.025, 0.975])
print(f"nested: n {len(found)} mean {np.mean([v for *_, v in found]):.12f} low {low:.4f} high {high:.4f}")

flat = np.array([((i * i) % 23) / 23 for i in range(40)])
result = stats.bootstrap((flat,), np.mean, n_resamples=400_000, batch=10_000, method="percentile", rng=rng)
low, high = result.confidence_interval
print(f"flat: n {len(flat)} mean {flat.mean():.12f} low {low:.4f} high {high:.4f}")
