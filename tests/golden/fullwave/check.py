"""Checks of the solver against exact solutions and against itself, and of the stored fields. Takes some minutes; prints the largest errors in parts of the
incident field at the receiver, and fails above 1e-4.

    python3 tests/golden/fullwave/check.py
"""

import json
from pathlib import Path

import numpy as np
from scipy.special import h2vp, hankel2, jv, jvp

from solver import Bodies, Solution, bessel

K = 2 * np.pi  # A wavelength is 1.
CONCRETE = np.sqrt(5.24 - 0.6322j - 0.5)
WORST = 1e-4


def report(name, error):
    print(f"{name}: {error:.1e}", flush=True)
    assert error < WORST, name


def relative(found, exact, x, source):
    return (np.abs(found - exact) / np.abs(bessel(K, np.abs(x - source))[0])).max()


def mie(radius, source, x, eta):
    """A cylinder around the origin: the series of Mie's kind."""
    m = np.arange(0, int(K * radius + 60))[:, None]
    ka, (r, s) = K * radius, (np.abs(x), np.abs(source))
    if eta is None:
        ratio = jv(m, ka) / hankel2(m, ka)
    else:
        ratio = (jvp(m, ka) - 1j * eta * jv(m, ka)) / (h2vp(m, ka) - 1j * eta * hankel2(m, ka))
    terms = ratio * hankel2(m, K * r) * hankel2(m, K * s) * np.cos(m * np.angle(x / source))
    terms[0] /= 2
    return bessel(K, np.abs(x - source))[0] - 2 * terms.sum(axis=0)


def wedge(k, open_rad, r, phi, r_s, phi_s):
    """Line source at a perfectly conducting wedge; angles from a face."""
    n = open_rad / np.pi
    v = np.arange(1, int(n * (abs(k) * max(r.max(), r_s) + 80)))[:, None] / n
    near, far = np.minimum(r, r_s), np.maximum(r, r_s)
    terms = jv(v, k * near) * hankel2(v, k * far) * np.sin(v * phi) * np.sin(v * phi_s)
    return 4 / n * np.nan_to_num(terms).sum(axis=0)


def circles():
    x = np.array([3.1, 1.7 + 2.9j, -2.2 + 1j, -4 - 0.5j, -2.05, 0.3 - 6j])
    for name, eta in [("perfect conductor", None), ("concrete", CONCRETE)]:
        solution = Solution(Bodies([], [(0, 2.0)]), K, [5.0 + 1j], eta)
        error = relative(solution.field(x)[:, 0], mie(2.0, 5.0 + 1j, x, eta), x, 5.0 + 1j)
        report(f"circle of {name} against Mie's series", error)


def wedges():
    """A little loss in the air, so that the other corners of a finite body do not matter."""
    k = K * (1 - 0.12j)
    for interior in [30, 60, 90, 120]:
        opened = np.radians(360 - interior)
        # The 0-face along the real axis, open angle counterclockwise from it.
        tip = 14 * np.exp(1j * opened)
        solution = Solution(Bodies([[0, tip, 14]]), k, [2 * np.exp(0.7j)])
        phi = np.linspace(0.05, 0.95, 25) * opened
        for r in [0.2, 1.0, 3.0]:
            x = r * np.exp(1j * phi)
            exact = wedge(k, opened, np.full(phi.shape, r), phi, 2.0, 0.7)
            found = solution.field(x)[:, 0]
            # The loss weakens the incident field too: where it is longest by a factor of 50.
            error = (np.abs(found - exact) / np.abs(bessel(k, np.abs(x - 2 * np.exp(0.7j)))[0])).max()
            report(f"corner of {interior} deg against the exact wedge, {r} wavelengths away", error)


def polygons():
    corners = [[0, 7, 7 + 5j, 5j], [10 + 1j, 16 + 0.5j, 15 + 6j], [-2 - 4j, 10 - 4j, 10 - 3.6j]]
    x = np.array([-3 + 2j, 8.5 + 3j, 12 + 9j, 3 + 8j, 18 + 2j, 5 - 1j])
    for name, eta in [("perfect conductor", None), ("concrete", CONCRETE)]:
        # All places are sources and receivers.
        def matrix(**options):
            solution = Solution(Bodies(corners, **options), K, x, eta)
            fields = solution.field(x + 1e-300)
            fields[np.diag_indices(len(x))] = 0
            return fields

        usual = matrix()
        scale = np.abs(bessel(K, np.abs(x[:, None] - x) + np.eye(len(x)))[0])
        report(f"{name}: reciprocity", (np.abs(usual - usual.T) / scale).max())
        fine = matrix(order=12, longest=0.9, levels=12)
        report(f"{name}: more and smaller panels", (np.abs(usual - fine) / scale).max())


def resonances():
    """A square whose inside resonates at this wavelength: as if it were a hair larger, and nothing inside."""
    x = np.array([-3 + 2j, 8.5 + 3j, 3 + 8j])
    within = np.array([0.5 + 0.7j, 1.9 + 3.1j, 3.3 + 2.2j, 4 + 0.4j])
    side = np.hypot(7, 6) / 2
    for name, eta in [("perfect conductor", None), ("concrete", CONCRETE)]:
        fields = []
        for a in [side, side * (1 + 1e-7)]:
            solution = Solution(Bodies([[0, a, a + 1j * a, 1j * a]]), K, [-2 - 3j], eta)
            fields.append(solution.field(x)[:, 0])
            report(f"resonance, {name}: field inside", np.abs(solution.field(within)).max())
        report(f"resonance, {name}: a hair beside it", relative(*fields, x, -2 - 3j))


def stored():
    """The fields in the files again, with a third more nodes."""
    for path in sorted(Path(__file__).parent.glob("*.json")):
        scene = json.loads(path.read_text())
        places = lambda name: np.array([complex(*p) for p in scene[name]])
        x, sources = places("receivers"), places("sources")
        polygons = [[complex(*p) for p in ring] for ring in scene["polygons"]]
        bodies = Bodies(polygons, order=9, longest=0.9, levels=11)
        for material, eta in [("perfect_conductor", None), ("impedance", complex(*scene["admittance"]))]:
            u = Solution(bodies, K, sources, eta).field(x)
            u = u * np.sqrt(np.pi * K / 2) * np.exp(-0.25j * np.pi)
            kept = np.array(scene[material]).view(complex).T
            incident = np.sqrt(1 / np.abs(x[:, None] - sources))
            report(f"{path.stem}, {material}", (np.abs(u - kept) / incident).max())
            deep = (np.abs(u) < 1e-2 * incident) & (np.abs(u) > 1e-4 * incident)
            error_db = 20 * np.abs(np.log10(np.abs(kept[deep]) / np.abs(u[deep])))
            print(f"    40 to 80 dB below the incident field: {error_db.max(initial=0):.2f} dB", flush=True)


if __name__ == "__main__":
    circles()
    wedges()
    polygons()
    resonances()
    stored()
