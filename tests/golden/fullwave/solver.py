"""The Helmholtz equation outside of bodies in the plane: a boundary integral solver.

A line source at s sends H0^(2)(k |x - s|), time factor e^{+j omega t}. Bodies are polygons (or circles, for a test), their normal n
points outwards. On their walls the field u is zero (a perfect conductor, field along the edges), or du/dn = j k eta u, an impedance
condition with the relative admittance eta. G = -j/4 H0^(2)(k r), S, K, K' the single layer, the double layer and its adjoint.

- Dirichlet: q = du/dn solves the combined field equation (1/2 + K' + j k S) q = du_i/dn + j k u_i, which has no resonances, and
  u = u_i - S q.
- Impedance: (1/2 - K + j k eta S) u = u_i on the walls, u = u_i + K u - j k eta S u elsewhere. That equation alone fails where the
  inside resonates. So random mixtures of what must be zero inside, u_i + K u - j k eta S u at points there, are added to its rows
  (Schenck, J. Acoust. Soc. Am. 44, 1968, pp. 41-58, who takes points inside as further rows).

Nystroem's method: panels of Gauss-Legendre nodes, a wavelength long at most, that shrink by a constant ratio towards corners, where
du/dn grows beyond all bounds. Unknowns are scaled by the roots of the weights (Bremer, J. Comput. Phys. 231, 2012, pp. 1879-1899).
What is nearer to a panel than its length and a half is integrated by interpolating the density there, with nodes
that crowd at the nearest point.

Places are complex numbers, x + j y.
"""

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander
from scipy.linalg import lu_factor, lu_solve
from scipy.special import hankel2, j0, j1, y0, y1

NEAR = 1.5  # in lengths of a panel
CROWD = 5  # power with which nodes crowd
CROWDED = 32  # of them on each side
ROWS = 128  # at once


def bessel(k, r):
    """H0^(2)(k r) and H1^(2)(k r)."""
    z = k * r
    if np.iscomplexobj(z):
        return hankel2(0, z), hankel2(1, z)
    with np.errstate(invalid="ignore"):  # At 0, where callers put something else.
        return j0(z) - 1j * y0(z), j1(z) - 1j * y1(z)


class Bodies:
    """Panels and nodes of polygons, each a list of corners counterclockwise, and circles (centre, radius)."""

    def __init__(self, polygons, circles=(), order=8, longest=1.0, levels=9, ratio=0.2):
        self.order, self.polygons = order, [np.asarray(p, complex) for p in polygons]
        ends, bends, walls = [], [], []
        for corners in self.polygons:
            for a, b in zip(corners, np.roll(corners, -1)):
                cuts = self.cuts(abs(b - a), longest, levels, ratio)
                ends += [(a + (b - a) * s, a + (b - a) * t) for s, t in zip(cuts, cuts[1:])]
                bends += [(0, 0)] * (len(cuts) - 1)
                walls += [max(walls, default=0) + 1] * (len(cuts) - 1)
        for centre, radius in circles:
            count = int(np.ceil(2 * np.pi * radius / longest)) + 4
            turn = np.exp(2j * np.pi * np.arange(count + 1) / count)
            ends += [(centre + radius * s, centre + radius * t) for s, t in zip(turn, turn[1:])]
            bends += [(centre, 2 * np.pi / count)] * count
            walls += [max(walls, default=0) + 1] * count
        ends, bends, self.wall = np.array(ends), np.array(bends), np.array(walls)
        self.a, self.b = ends.T
        self.centre, self.bend = bends[:, 0], bends[:, 1].real
        self.length = np.abs(self.b - self.a)
        # n d / r^2 between places of one wall, which rounding spoils where they are close.
        self.curvature = np.where(
            self.bend != 0, 0.5 / np.maximum(np.abs(self.a - self.centre), 1e-9), 0
        )
        nodes, weights = leggauss(order)
        self.t, self.w = (nodes + 1) / 2, weights / 2
        self.inverse = np.linalg.inv(legvander(nodes, order - 1))
        panels = np.arange(len(self.a))[:, None]
        x, n, speed = self.at(panels, self.t[None, :])
        self.x, self.n, self.weight = x.ravel(), n.ravel(), (speed * self.w).ravel()

    @staticmethod
    def cuts(length, longest, levels, ratio):
        """Ends of the panels of a wall, 0 to 1."""
        count = max(2, int(np.ceil(length / longest)))
        corner = ratio ** np.arange(levels, 0, -1)
        inner = np.arange(1, count)
        return np.concatenate(([0], corner, inner, count - corner[::-1], [count])) / count

    def at(self, panel, t):
        """Place, normal and speed at the parameter t, 0 to 1, of panels."""
        a, b = self.a[panel], self.b[panel]
        centre, bend = self.centre[panel], self.bend[panel]
        bent = bend != 0
        arm = (a - centre) * np.exp(1j * bend * t)
        x = np.where(bent, centre + arm, a + (b - a) * t)
        along = np.where(bent, 1j * bend * arm, (b - a) + 0 * t)
        return x, -1j * along / np.abs(along), np.abs(along)

    def kernels(self, k, x, n_x, y, n_y, same, panel):
        """G, and its derivative along the normal at x (if there is one) or y. same: x is on the wall of the panel that y is on."""
        d = x - y
        r = np.abs(d)
        h0, h1 = bessel(k, r)
        n, d = (n_y, -d) if n_x is None else (n_x, d)
        along = np.where(same, r * self.curvature[panel], (n * np.conj(d)).real / r)
        return -0.25j * h0, 0.25j * k * h1 * along

    def layers(self, k, x, n_x=None, own=False):
        """Matrices of S and K (of S and K' where normals at x are given) from the density at the nodes to places x; in blocks of rows.

        own: x are the nodes themselves.
        """
        columns = np.arange(len(self.x)) // self.order
        for first in range(0, len(x), ROWS):
            rows = slice(first, first + ROWS)
            at, normal = x[rows, None], None if n_x is None else n_x[rows, None]
            wall = self.wall[columns[rows]] if own else np.zeros(len(at))
            same = wall[:, None] == self.wall[columns]
            with np.errstate(all="ignore"):
                s, k_ = self.kernels(
                    k, at, normal, self.x[None, :], self.n[None, :], same, columns[None, :]
                )
            s, k_ = s * self.weight, k_ * self.weight
            if own:  # The diagonal is replaced below.
                i = np.arange(len(at))
                s[i, first + i] = k_[i, first + i] = 0
            self.correct(k, x[rows], None if n_x is None else n_x[rows], wall, s, k_)
            yield rows, s, k_

    def correct(self, k, x, n_x, wall, s, k_):
        """Replaces what is near."""
        chord = self.b - self.a
        t = ((x[:, None] - self.a) * np.conj(chord)).real / self.length**2
        distance = np.abs(x[:, None] - self.a - chord * np.clip(t, 0, 1))
        i, panel = np.nonzero(distance < NEAR * self.length)
        if not len(i):
            return
        t = self.nearest(panel, x[i], np.clip(t[i, panel], 0, 1))[:, None]
        crowded, weights = leggauss(CROWDED)
        crowded, weights = (crowded + 1) / 2, weights / 2
        part = crowded**CROWD
        weights = weights * CROWD * crowded ** (CROWD - 1)
        at = np.concatenate((t - t * part, t + (1 - t) * part), axis=1)
        weights = np.concatenate((t * weights, (1 - t) * weights), axis=1)
        y, n_y, speed = self.at(panel[:, None], at)
        normal = None if n_x is None else n_x[i, None]
        with np.errstate(all="ignore"):
            same = (wall[i] == self.wall[panel])[:, None]
            g, dg = self.kernels(k, x[i, None], normal, y, n_y, same, panel[:, None])
        # No length, no weight: nodes that fall on x itself.
        g, dg = (np.where(np.isfinite(v), v, 0) * weights * speed for v in (g, dg))
        basis = legvander(2 * at - 1, self.order - 1) @ self.inverse
        columns = panel[:, None] * self.order + np.arange(self.order)
        s[i[:, None], columns] = np.einsum("mq,mqp->mp", g, basis)
        k_[i[:, None], columns] = np.einsum("mq,mqp->mp", dg, basis)

    def nearest(self, panel, x, t):
        bend, centre = self.bend[panel], self.centre[panel]
        with np.errstate(all="ignore"):
            turned = np.angle((x - centre) / (self.a[panel] - centre)) / bend
        return np.where(bend != 0, np.clip(np.nan_to_num(turned), 0, 1), t)

    def inside(self, count, seed=1):
        """Random places inside of the polygons, by their sizes, off the walls."""
        rng, places = np.random.default_rng(seed), []
        boxes = [(c.real.min(), c.real.max(), c.imag.min(), c.imag.max()) for c in self.polygons]
        areas = np.array([(b[1] - b[0]) * (b[3] - b[2]) for b in boxes])
        while len(places) < count:
            c = rng.choice(len(boxes), p=areas / areas.sum())
            x = rng.uniform(*boxes[c][:2]) + 1j * rng.uniform(*boxes[c][2:])
            if is_inside(self.polygons[c], x) and wall_distance(self.polygons[c], x) > 0.1:
                places.append(x)
        return np.array(places)


def is_inside(corners, x):
    a, b = corners - x, np.roll(corners, -1) - x
    crosses = (a.imag > 0) != (b.imag > 0)
    with np.errstate(all="ignore"):
        at = a.real - a.imag * (b.real - a.real) / (b.imag - a.imag)
    return np.count_nonzero(crosses & (at > 0)) % 2 == 1


def wall_distance(corners, x):
    chord = np.roll(corners, -1) - corners
    t = np.clip(((x - corners) * np.conj(chord)).real / np.abs(chord) ** 2, 0, 1)
    return np.abs(x - corners - chord * t).min()


class Solution:
    """The fields of line sources outside of bodies; admittance: eta, or None for a perfect conductor."""

    def __init__(self, bodies, k, sources, admittance=None):
        self.bodies, self.k, self.admittance = bodies, k, admittance
        self.sources = np.asarray(sources, complex)
        x, n, root = bodies.x, bodies.n, np.sqrt(bodies.weight)
        matrix = np.empty((len(x), len(x)), complex)
        d = x[:, None] - self.sources
        h0, h1 = bessel(k, np.abs(d))
        if admittance is None:
            for rows, s, k_ in bodies.layers(k, x, n, own=True):
                matrix[rows] = (k_ + 1j * k * s) * root[rows, None] / root
            along = (n[:, None] * np.conj(d)).real / np.abs(d)
            right = -k * h1 * along + 1j * k * h0
        else:
            for rows, s, k_ in bodies.layers(k, x, own=True):
                matrix[rows] = (1j * k * admittance * s - k_) * root[rows, None] / root
            right = h0
        matrix[np.diag_indices(len(x))] += 0.5
        right = right * root[:, None]
        if admittance is not None and bodies.polygons:
            within = bodies.inside(max(20, len(x) // 20))
            rng = np.random.default_rng(2)
            mix = rng.normal(size=(len(x), len(within))) / np.sqrt(len(x))
            zero = np.concatenate(
                [1j * k * admittance * s - k_ for _, s, k_ in bodies.layers(k, within)]
            )
            matrix += 1j * mix @ (zero / root)
            right = right + 1j * mix @ bessel(k, np.abs(within[:, None] - self.sources))[0]
        factors = lu_factor(matrix, overwrite_a=True, check_finite=False)
        self.density = lu_solve(factors, right, check_finite=False) / root[:, None]

    def field(self, x):
        """The total field at places outside: a row each, a column a source."""
        x = np.asarray(x, complex)
        u = bessel(self.k, np.abs(x[:, None] - self.sources))[0]
        for rows, s, k_ in self.bodies.layers(self.k, x):
            if self.admittance is None:
                u[rows] -= s @ self.density
            else:
                u[rows] += (k_ - 1j * self.k * self.admittance * s) @ self.density
        return u
