"""Golden values for aps-metrics, from SciPy's find_peaks and plain NumPy.

    python3 metrics.py [--labels FILE.npy]

writes the arrays in metrics/ beside this file. Nothing here is fast or clever on purpose: each
metric is spelled out from its definition, and the ring is searched by laying three copies side by
side. All spectra are integers over 4096, so that both languages make them bit for bit; only the
labels are stored, the other families follow from a hash.

--labels takes spectra, shape (800, 180), on the normalised target scale (zero mean, unit
variance), for example from a traced data set. Without it, labels of random path sets are made.
Those stored are of `cargo xtask dataset --protocol released --limits r2d1 --tx-per-map 8 --rx-per-map 50`
(ten synthetic cities): 80 valid links a map, each standardised.
"""

import argparse
import warnings
from pathlib import Path

import numpy as np
from scipy.signal import find_peaks, peak_prominences

BINS = 180
SCALE = 4096
LABELS = 800
PER_FAMILY = 200
FAMILIES = 8
SAMPLES = LABELS + FAMILIES * PER_FAMILY
DATA_RANGE = 16.0
OUT = Path(__file__).parent / "metrics"

# ---------------------------------------------------------------- spectra


def mix(*key):
    """SplitMix64's finaliser over a few small integers."""
    z = 0
    for part in key:
        z = (z + part + 0x9E3779B97F4A7C15) & 0xFFFFFFFFFFFFFFFF
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & 0xFFFFFFFFFFFFFFFF
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & 0xFFFFFFFFFFFFFFFF
        z ^= z >> 31
    return z


def family_spectrum(family, i):
    """Spectrum i of a family, in units of 1/4096."""
    h = lambda *key: mix(family, i, *key)
    bins = range(BINS)
    if family == 0:  # random
        return [h(j) % 16384 - 4096 for j in bins]
    if family == 1:  # four levels: ties everywhere
        return [1024 * (h(j) % 4) - 1024 for j in bins]
    if family == 2:  # plateaus
        width = 2 + h(999) % 9
        return [h(j // width) % 8192 - 2048 for j in bins]
    if family == 3:  # ramps and saw teeth
        slope, start, period = 1 + h(1000) % 60, h(1001) % 4096, 2048 << (h(1002) % 4)
        sign = 1 if i % 2 == 0 else -1
        return [sign * ((j * slope + start) % period) - 512 for j in bins]
    if family == 4:  # one spike, at either end or anywhere
        place = [0, BINS - 1, h(1000) % BINS][i % 3]
        return [4096 if j == place else -64 * (i % 4) for j in bins]
    if family == 5:  # constants, zero and negative ones among them
        return [4096 * (i % 5 - 2)] * BINS
    if family == 6:  # negative everywhere
        return [-1 - h(j // (1 + i % 3)) % 12288 for j in bins]
    # a few isolated peaks on a floor
    return [8192 - h(j) % 8000 if h(j, 7) % 23 == 0 else -400 for j in bins]


def make_labels():
    """Labels of random path sets: the formula as it stands, normalised a sample."""
    rng = np.random.default_rng(20)
    elements, spacing, rate = 16, 0.5, 200e6
    labels = np.empty((LABELS, BINS))
    for i in range(LABELS):
        paths = rng.integers(1, 13)
        power = 10 ** (-rng.uniform(0, 40, paths) / 10)
        delay = rng.uniform(50e-9, 900e-9, paths)
        arrival = rng.uniform(-np.pi, np.pi, paths)
        theta = np.radians(np.linspace(-180, 180, BINS, endpoint=i % 2 == 0))
        tau = np.linspace(0, 1000e-9, 128 if i % 2 == 0 else 2048)
        psi = np.pi * spacing * (np.sin(theta) - np.sin(arrival)[:, None])
        with np.errstate(invalid="ignore"):
            array = np.sin(elements * psi) / (elements * np.sin(psi))
        array[np.abs(np.sin(psi)) < 1e-12] = 1.0
        pulse = np.sinc(rate * (tau - delay[:, None])) ** 2
        aps = np.einsum("k,kt,ka->ta", power, pulse, array**2).max(axis=0)
        db = 10 * np.log10(aps + 1e-35)
        linear = 10 ** ((db - db.max()) / 10)
        labels[i] = (linear - linear.mean()) / (linear.std() + 1e-8)
    return labels


def make_spectra(labels):
    """Truth and prediction of every sample, in units of 1/4096."""
    truth = [4 * row.astype(np.int64) for row in labels]
    for family in range(FAMILIES):
        truth += [np.array(family_spectrum(family, i)) for i in range(PER_FAMILY)]
    prediction = []
    for i, row in enumerate(truth):
        kind = i % 5
        if kind == 0:  # perfect
            p = row
        elif kind == 1:  # turned by a few bins
            p = np.roll(row, 1 + mix(50, i) % 5)
        elif kind == 2:  # noisy
            p = row + np.array([mix(51, i, j) % 1024 for j in range(BINS)]) - 512
        elif kind == 3:  # somebody else's
            p = truth[(i + 1) % len(truth)]
        else:  # mirror twins, one half a little weaker
            p = np.array([row[(BINS // 2 - j) % BINS] - 100 * (j % 2) for j in range(BINS)])
        prediction.append(p)
    return np.array(truth) / SCALE, np.array(prediction) / SCALE


# ---------------------------------------------------------------- metrics


def angle_deg(t, p):
    """arccos of the cosine, by Kahan's formula, which keeps its digits near 0 and 180 deg."""
    t_norm, p_norm = np.linalg.norm(t), np.linalg.norm(p)
    if t_norm == 0 or p_norm == 0:
        return 90.0
    u, v = t * p_norm, p * t_norm
    return np.degrees(2 * np.arctan2(np.linalg.norm(u - v), np.linalg.norm(u + v)))


def pointwise(t, p):
    mse = np.mean((t - p) ** 2)
    nmse = mse / max(np.mean(t**2), 1e-12)
    cos = np.dot(t, p) / (max(np.linalg.norm(t), 1e-8) * max(np.linalg.norm(p), 1e-8))
    cos = np.clip(cos, -1, 1)
    return [
        np.mean(np.abs(t - p)),
        20 * np.log10(DATA_RANGE) - 10 * np.log10(max(mse, 1e-12)),
        cos,
        10 * np.log10(max(nmse, 1e-12)),
        angle_deg(t, p),
        mse,
        np.sqrt(mse),
        nmse,
    ]


def ring_peaks(x, prominence):
    n = len(x)
    peaks, _ = find_peaks(np.tile(x, 3), prominence=prominence)
    return np.array([k - n for k in peaks if n <= k < 2 * n], dtype=int)


def scaled_peaks(x, protocol):
    """Scaled spectrum and its peaks."""
    if protocol == "released":
        scaled = x / (x.max() + 1e-8)
        return scaled, find_peaks(scaled, prominence=0.05)[0]
    if not x.max() > 0:
        return x, np.array([], dtype=int)
    scaled = x / x.max()
    return scaled, ring_peaks(scaled, 0.05)


def dominant(scaled, peaks):
    if len(peaks) == 0:
        return peaks
    heights = scaled[peaks]
    chosen = peaks[heights / (heights.sum() + 1e-8) >= 0.1]
    return chosen if len(chosen) else peaks[[np.argmax(heights)]]


def strongest(scaled, peaks):
    return peaks[np.argmax(scaled[peaks])]


def peak_metrics(t, p, protocol):
    """PLE, Hit@2, Hit@4, Rec.@2, Rec.@4, then PLE, Hit@2, Hit@4 with mirror twins."""
    t, t_peaks = scaled_peaks(t, protocol)
    p, p_peaks = scaled_peaks(p, protocol)
    t_dominant, p_dominant = dominant(t, t_peaks), dominant(p, p_peaks)
    turn, degrees = (BINS, 360 / BINS) if protocol == "paper" else (BINS - 1, 1.0)

    def circular(a, b):
        way = abs(a - b) % turn
        return degrees * min(way, turn - way)

    def plain(a, b):
        return circular(a, b) if protocol == "paper" else degrees * abs(a - b)

    def mirror(a, b):
        return min(circular(a, b), circular(a, (turn / 2 - b) % turn))

    def ple(distance):
        if len(t_peaks) == 0:
            return 0.0
        if len(p_peaks) == 0:
            return 180.0
        return np.mean([min(distance(a, b) for b in p_peaks) for a in t_dominant])

    def hit(distance, delta):
        if len(t_peaks) == 0 or len(p_peaks) == 0:
            return 0.0
        return float(distance(strongest(t, t_dominant), strongest(p, p_dominant)) <= delta)

    def recall(delta):
        candidates = p_peaks if protocol == "paper" else p_dominant
        if len(t_peaks) == 0:
            return 1.0
        found = [any(plain(a, b) <= delta for b in candidates) for a in t_dominant]
        return np.mean(found)

    return [ple(plain), hit(plain, 2), hit(plain, 4), recall(2), recall(4),
            ple(mirror), hit(mirror, 2), hit(mirror, 4)]


# ---------------------------------------------------------------- output


def ragged(lists):
    """One flat array: a count, then that many bins, spectrum after spectrum."""
    return np.array([v for row in lists for v in (len(row), *row)], dtype=np.uint8)


def summary(column):
    quantiles = np.quantile(column, [0.05, 0.25, 0.5, 0.75, 0.95])
    return [column.mean(), column.std(), column.min(), *quantiles, column.max()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--labels", type=Path)
    args = parser.parse_args()
    warnings.filterwarnings("ignore", message="some peaks have a prominence of 0")

    labels = np.load(args.labels) if args.labels else make_labels()
    assert labels.shape == (LABELS, BINS), labels.shape
    quantised = np.round(labels * (SCALE / 4)).astype(np.int16)
    truth, prediction = make_spectra(quantised)

    spectra = [row for pair in zip(truth, prediction) for row in pair]
    weighted = []
    for x in spectra:
        peaks, _ = find_peaks(x)
        # Exact: all terms are integers over 4096.
        weighted.append(np.dot(peak_prominences(x, peaks)[0], peaks + 1))
    flat = np.array([pointwise(t, p) for t, p in zip(truth, prediction)])
    peaky = np.array([[peak_metrics(t, p, protocol) for t, p in zip(truth, prediction)]
                      for protocol in ("paper", "released")])
    # Columns in the order of the paper's table, then the others.
    columns = [np.hstack([flat[:, :5], part[:, :5], flat[:, 5:], part[:, 5:]]) for part in peaky]

    OUT.mkdir(exist_ok=True)
    np.save(OUT / "labels.npy", quantised)
    np.save(OUT / "prominences.npy", np.array(weighted))
    for protocol in ("paper", "released"):
        found = [scaled_peaks(x, protocol)[1] for x in spectra]
        np.save(OUT / f"peaks_{protocol}.npy", ragged(found))
    np.save(OUT / "pointwise.npy", flat)
    np.save(OUT / "peak_metrics.npy", peaky)
    np.save(OUT / "summary.npy", [[summary(c) for c in part.T] for part in columns])

    # The released code divides in float32. How often does that move a peak of a label?
    single = [find_peaks((x := row.astype(np.float32)) / (x.max() + np.float32(1e-8)),
                         prominence=0.05)[0] for row in labels]
    double = [scaled_peaks(row.astype(np.float32).astype(float), "released")[1] for row in labels]
    moved = sum(not np.array_equal(a, b) for a, b in zip(single, double))
    print(f"{SAMPLES} samples; float32 scaling changes the peaks of {moved} of {LABELS} labels")


if __name__ == "__main__":
    main()
