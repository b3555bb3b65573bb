"""The polynomial by which aps-model computes the normal distribution in f32 (kernels/exponential.rs).

Mills' ratio m(x) = Q(x) / phi(x), x >= 0, is t P(t) with t = 1 / (1 + C x). P is fitted for the least largest relative error
(Lawson's iteration) on 0 <= x <= 14.5, beyond which Q is below f32's smallest number. Prints the coefficients, the highest
power first, and the error of the fit.

    python3 tests/golden/mills.py
"""

import numpy as np
from scipy.special import erfcx

C, DEGREE, LAST = 0.35, 8, 14.5

first = 1 / (1 + C * LAST)
t = first + (1 - first) * (np.cos(np.pi * (np.arange(400) + 0.5) / 400) + 1) / 2
x = (1 / t - 1) / C
wanted = np.sqrt(np.pi / 2) * erfcx(x / np.sqrt(2)) / t
basis = np.polynomial.chebyshev.chebvander(2 * (t - first) / (1 - first) - 1, DEGREE)
weights = np.ones_like(t)
for _ in range(60):
    scale = np.sqrt(weights) / wanted
    fit = np.linalg.lstsq(basis * scale[:, None], wanted * scale, rcond=None)[0]
    error = np.abs(basis @ fit / wanted - 1)
    weights *= error + 1e-18
    weights /= weights.sum()
powers = np.polynomial.chebyshev.Chebyshev(fit, domain=[first, 1]).convert(kind=np.polynomial.Polynomial).coef
print("P, highest power first:", *(np.float32(p) for p in powers[::-1]))
print(f"largest relative error {error.max():.1e}")
