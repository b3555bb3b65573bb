"""Golden values for Polar-Reg, from PyTorch's own layers in double precision.

    python3 polar_reg.py

writes models/polar_reg.safetensors beside this file. Weights, inputs and targets follow from a hash of a name and an index, as
those of models.py do, so none is stored.

# The model

A link is some ways, each of 14 features, one of 720 directions around the receiver and one of 15 kinds (5, after 0 to 2 bounces;
aps_raytrace::polar). A perceptron, given the features of a way and a unit vector for its kind, makes the logarithm of the way's
strength. The strengths of a direction's ways are added, each times the share of the ray that the way arrives along; the sum over that
of all directions is the share of the power that arrives from each. The array's response, a matrix that is not learnt, makes a
spectrum of it, which is divided by its maximum and standardised by the mean and the deviation of the labels it is trained on.

| tensor | shape |
|---|---|
| ways.embed.weight, .bias | (48, 29): features, then kinds; then GELU by the error function |
| ways.hidden.weight, .bias | (48, 48); then GELU |
| ways.out.weight, .bias | (1, 48): a sixth of the logarithm of the strength |

# The arrays of the file

As those of models.py, rows of tensors being in the order of their names:

- eval: outputs in evaluation mode; eval_8: those with an array of 8 elements;
- power: the shares by direction behind eval;
- train: the output of the first training step, before it moves anything;
- losses: of each of three training steps;
- gradients: of the first step, a row a learnt tensor: norm, then the gradient at four sampled elements;
- after: all tensors after the third step, a row each: norm, then four sampled elements;
- array: the same for the array's matrix (bin, direction).

A step is one batch of two links, gradients clipped to norm 1, AdamW (3e-4, weight decay 0.01). The loss is the mean absolute
difference of the standardised spectra, plus 1 less their cosine, averaged over the links.
"""

import math

import numpy as np
import torch
from torch import nn

from models import BATCH, BINS, OUT, definitions, gradients, row, save, set_weights, values

package = definitions()
KINDS, FEATURES = package.POLAR_KINDS, package.POLAR_FEATURES
DIRECTIONS = package.POLAR_DIRECTIONS
MEAN, DEVIATION = 0.125, 0.25


def array_response(elements, bins=BINS, directions=DIRECTIONS):
    """Power response of a half-wavelength linear array on the y axis, at most 1: (bin, direction).

    Bins point to -180 degrees and on, directions to half a step and on: rays of the fan.
    """
    looks = -math.pi + torch.arange(bins).double() * (2 * math.pi / bins)
    arrives = (torch.arange(directions).double() + 0.5) * (2 * math.pi / directions)
    half_phase = 0.5 * math.pi * (torch.sin(looks)[:, None] - torch.sin(arrives)[None])
    one = torch.sin(half_phase)
    many = torch.sin(elements * half_phase)
    return torch.where(one.abs() < 1e-12, 1.0, many / (elements * one)) ** 2


def loss_of(y, a):
    cosine = (y * a).sum(1) / torch.sqrt((y * y).sum(1) * (a * a).sum(1) + 1e-12)
    return (y - a).abs().mean() + (1 - cosine).mean()


def inputs():
    """A way from each direction and of each kind, features between 0 and 1, feature 1 being 1; half of them are zeros instead."""
    features = values("ways", BATCH * DIRECTIONS * KINDS * FEATURES).reshape(BATCH, DIRECTIONS * KINDS, FEATURES)
    is_there = features[..., 1:2] > 0
    features = np.abs(features)
    features[..., 1] = 1.0
    number = np.arange(DIRECTIONS * KINDS)
    numbers = np.broadcast_to(np.stack([number // KINDS, number % KINDS], -1), (BATCH, DIRECTIONS * KINDS, 2))
    return torch.from_numpy(np.where(is_there, np.concatenate([features, numbers], -1), 0.0))


def targets():
    """Standardised spectra with maximum 1, most of them low."""
    power = ((values("spectra", BATCH * BINS) + 1) / 2).reshape(BATCH, BINS) ** 4
    return torch.from_numpy((power / power.max(1, keepdims=True) - MEAN) / DEVIATION)


def train(net, x, a):
    out = {"losses": []}
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)
    net.train()
    for step in range(3):
        y = net(x)
        loss = loss_of(y, a)
        optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["train"], out["gradients"] = y.detach().numpy(), gradients(net)
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        out["losses"].append(loss.item())
    out["after"] = np.array([row(name, t) for name, t in sorted(net.state_dict().items()) if not name.startswith("fixed.")])
    return out


def model():
    """The model with weights by the rule, in evaluation, told of an array of 16 elements."""
    net = package.PolarReg()
    fixed, net.fixed = net.fixed.double(), nn.Identity()
    net = set_weights(net)
    net.fixed = fixed
    fixed.array, fixed.mean, fixed.deviation = array_response(16), torch.tensor(MEAN).double(), torch.tensor(DEVIATION).double()
    return net.eval()


def main():
    OUT.mkdir(exist_ok=True)
    net, x = model(), inputs()
    fixed = net.fixed
    out = {"array": np.array([row("array", fixed.array)])}
    with torch.no_grad():
        out["power"], out["eval"] = net.power(x).numpy(), net(x).numpy()
        of_16, fixed.array = fixed.array, array_response(8)
        out["eval_8"] = net(x).numpy()
        fixed.array = of_16
    out |= train(net, x, targets())
    save(OUT / "polar_reg.safetensors", out)
    count = sum(p.numel() for p in net.parameters())
    spread = {k: f"{out[k].std():.3g} {abs(out[k][0] - out[k][1]).mean():.3g}" for k in ("power", "eval", "eval_8", "train")}
    print(count, "values; std and difference of the links:", spread, "losses:", out["losses"])


if __name__ == "__main__":
    main()
