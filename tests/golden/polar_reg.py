"""Golden values for Polar-Reg, from PyTorch's own layers in double precision.

    python3 polar_reg.py

writes models/polar_reg.safetensors beside this file. Weights, inputs and targets follow from a hash of a name and an index, as
those of models.py do, so none is stored.

# The model

A link is 12 planes over 40 ranges and 180 directions around the receiver, and 4 numbers a direction (the fields of
aps-raytrace). Convolutions over range and direction are circular in direction and halve the ranges, 40 to 20, 10 and 5. What is
left of the ranges, times channels, joins the numbers as features of each direction; six residual blocks of depthwise circular
convolutions, dilated by 1, 2, 4, 1, 2 and 4, mix the directions. A softmax over directions is the share of the power that
arrives from each; the array's response, a matrix that is not learnt, makes a spectrum of it, which is divided by its maximum
and standardised by the mean and the deviation of the labels it is trained on.

| tensor | shape |
|---|---|
| stem.N.conv.weight, N = 0, 1, 2 | (24, 12, 3, 3), (32, 24, 3, 3), (40, 32, 3, 3): output, input, range, direction |
| stem.N.norm.* | batch normalisation, then ReLU |
| project.weight, .bias | (96, 204, 1): channel times 5 plus range, then the numbers; then ReLU |
| blocks.N.depthwise.weight | (96, 1, 9) |
| blocks.N.norm.* | batch normalisation |
| blocks.N.expand.*, .contract.* | (192, 96, 1), then GELU by the error function; (96, 192, 1) |
| blocks.N.gate.* | (96, 96): of the mean over directions of what the block was given, then the logistic function |
| head.weight, .bias | (1, 96, 1) |

# The arrays of the file

As those of models.py, rows of tensors being in the order of their names:

- eval: outputs in evaluation mode; eval_8: those with an array of 8 elements;
- power: the shares by direction behind eval;
- train: the output of the first training step, before it moves anything;
- losses: of each of three training steps;
- gradients: of the first step, a row a learnt tensor: norm, then the gradient at four sampled elements;
- input_gradients: of the first step, for planes and numbers, rows of the same kind;
- after: all tensors after the third step, a row each: norm, then four sampled elements;
- array: the same for the array's matrix (bin, direction).

A step is one batch of two links, gradients clipped to norm 1, AdamW (3e-4, weight decay 0.01). The loss is the mean absolute
difference of the standardised spectra, plus 1 less their cosine, averaged over the links.
"""

import math

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

from models import BATCH, BINS, OUT, gradients, row, save, set_weights, tensors, values

PLANES, NUMBERS, RANGES, DIRECTIONS = 12, 4, 40, 180
MEAN, DEVIATION = 0.125, 0.25


def array_response(elements, bins=BINS, directions=DIRECTIONS):
    """Power response of a half-wavelength linear array on the y axis, at most 1: (bin, direction).

    Bins point to -180 degrees and on, directions to half a step and on: rays of the fan that the fields are taken along.
    """
    looks = -math.pi + torch.arange(bins).double() * (2 * math.pi / bins)
    arrives = (torch.arange(directions).double() + 0.5) * (2 * math.pi / directions)
    half_phase = 0.5 * math.pi * (torch.sin(looks)[:, None] - torch.sin(arrives)[None])
    one = torch.sin(half_phase)
    many = torch.sin(elements * half_phase)
    return torch.where(one.abs() < 1e-12, 1.0, many / (elements * one)) ** 2


class Circular(nn.Module):
    """3 x 3 convolution, circular in direction, zeros beyond the ranges, every other range; normalised and rectified."""

    def __init__(self, a, b):
        super().__init__()
        self.conv = nn.Conv2d(a, b, 3, stride=(2, 1), padding=(1, 0), bias=False)
        self.norm = nn.BatchNorm2d(b)

    def forward(self, x):
        return F.relu(self.norm(self.conv(F.pad(x, (1, 1, 0, 0), mode="circular"))))


class Block(nn.Module):
    def __init__(self, channels, size, dilation):
        super().__init__()
        self.reach = dilation * (size // 2)
        self.depthwise = nn.Conv1d(channels, channels, size, dilation=dilation, groups=channels, bias=False)
        self.norm = nn.BatchNorm1d(channels)
        self.expand = nn.Conv1d(channels, 2 * channels, 1)
        self.contract = nn.Conv1d(2 * channels, channels, 1)
        self.gate = nn.Linear(channels, channels)

    def forward(self, x):
        y = self.norm(self.depthwise(F.pad(x, (self.reach, self.reach), mode="circular")))
        y = self.contract(F.gelu(self.expand(y)))
        return x + y * torch.sigmoid(self.gate(x.mean(2)))[:, :, None]


class PolarReg(nn.Module):
    def __init__(self, response, channels=(24, 32, 40), width=96, blocks=6, size=9):
        super().__init__()
        sizes = [PLANES, *channels]
        self.stem = nn.Sequential(*[Circular(a, b) for a, b in zip(sizes, sizes[1:])])
        ranges = RANGES
        for _ in channels:
            ranges = (ranges + 1) // 2
        self.project = nn.Conv1d(channels[-1] * ranges + NUMBERS, width, 1)
        self.blocks = nn.ModuleList([Block(width, size, 1 << n % 3) for n in range(blocks)])
        self.head = nn.Conv1d(width, 1, 1)
        # Follows from the array's description: no file of weights holds it.
        self.register_buffer("array", response, persistent=False)

    def power(self, planes, numbers):
        """Share of the power by direction (link, direction)."""
        x = self.stem(planes).flatten(1, 2)
        x = F.relu(self.project(torch.cat([x, numbers], 1)))
        for block in self.blocks:
            x = block(x)
        return torch.softmax(self.head(x)[:, 0], 1)

    def forward(self, planes, numbers):
        spectrum = self.power(planes, numbers) @ self.array.T
        spectrum = spectrum / (spectrum.amax(1, keepdim=True) + 1e-9)
        return (spectrum - MEAN) / DEVIATION


def loss_of(y, a):
    cosine = (y * a).sum(1) / torch.sqrt((y * y).sum(1) * (a * a).sum(1) + 1e-12)
    return (y - a).abs().mean() + (1 - cosine).mean()


def inputs():
    """Planes between 0 and 1, half of them 0 as shadows are; numbers between -1 and 1."""
    planes = values("planes", BATCH * PLANES * RANGES * DIRECTIONS).reshape(BATCH, PLANES, RANGES, DIRECTIONS)
    numbers = values("numbers", BATCH * NUMBERS * DIRECTIONS).reshape(BATCH, NUMBERS, DIRECTIONS)
    return torch.from_numpy(planes).clamp(min=0), torch.from_numpy(numbers)


def targets():
    """Standardised spectra with maximum 1, most of them low."""
    power = ((values("spectra", BATCH * BINS) + 1) / 2).reshape(BATCH, BINS) ** 4
    return torch.from_numpy((power / power.max(1, keepdims=True) - MEAN) / DEVIATION)


def train(net, planes, numbers, a):
    out = {"losses": []}
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)
    planes.requires_grad_(), numbers.requires_grad_()
    net.train()
    for step in range(3):
        y = net(planes, numbers)
        loss = loss_of(y, a)
        optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["train"], out["gradients"] = y.detach().numpy(), gradients(net)
            out["input_gradients"] = np.array([row("planes", planes.grad), row("numbers", numbers.grad)])
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        out["losses"].append(loss.item())
    out["after"] = tensors(net)
    return out


def main():
    OUT.mkdir(exist_ok=True)
    net = set_weights(PolarReg(array_response(16)))
    planes, numbers = inputs()
    out = {"array": np.array([row("array", net.array)])}
    net.eval()
    with torch.no_grad():
        out["power"], out["eval"] = net.power(planes, numbers).numpy(), net(planes, numbers).numpy()
        of_16, net.array = net.array, array_response(8)
        out["eval_8"] = net(planes, numbers).numpy()
        net.array = of_16
    out |= train(net, planes, numbers, targets())
    save(OUT / "polar_reg.safetensors", out)
    count = sum(p.numel() for p in net.parameters())
    spread = {k: f"{out[k].std():.3g} {abs(out[k][0] - out[k][1]).mean():.3g}" for k in ("power", "eval", "eval_8", "train")}
    print(count, "values; std and difference of the links:", spread, "losses:", out["losses"])


if __name__ == "__main__":
    main()
