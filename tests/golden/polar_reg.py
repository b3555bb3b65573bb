"""Golden values for Polar-Reg, from PyTorch's own layers in double precision.

    python3 polar_reg.py

writes models/polar_reg.safetensors beside this file. Weights, inputs and targets follow from a hash of a name and an index, as
those of models.py do, so none is stored.

# The model

A link is, for each of 180 directions around the receiver, 14 features of each of 15 ways (5 kinds, 0 to 2 bounces) and 4 numbers
(aps_raytrace::polar). A perceptron, the same for all ways but for a learnt vector a kind and number of bounces, turns the features
of a way into the logarithm of its strength and 8 further values. The strengths of a direction's ways are added, each times the
share of the ray that the way arrives along. The further values of all ways, the numbers and the logarithm of the sum are features of
the direction; residual blocks of depthwise circular convolutions, dilated by 1, 2 and 4 in turn, mix the directions and add
a correction. A softmax over directions is the share of the power that arrives from each; the array's response, a matrix that is
not learnt, makes a spectrum of it, which is divided by its maximum and standardised by the mean and the deviation of the labels it
is trained on.

| tensor | shape |
|---|---|
| ways.embed.weight | (H, 14) |
| ways.kind | (15, H): added to the embedding; then GELU by the error function |
| ways.hidden.weight, .bias | (H, H); then GELU |
| ways.out.weight, .bias | (9, H): a sixth of the logarithm of the strength, then the further values, which count where there is a way |
| project.weight | (W, 125): further values of all ways, numbers, logarithm of the sum |
| norm.* | batch normalisation over links and directions, then ReLU |
| blocks.N.depthwise.weight | (W, 1, 7) |
| blocks.N.norm.* | batch normalisation |
| blocks.N.expand.*, .contract.* | (2 W, W), then GELU; (W, 2 W) |
| blocks.N.gate.* | (W, W): of the mean over directions of what the block was given, then the logistic function |
| head.weight, .bias | (1, W) |

# The arrays of the file

As those of models.py, rows of tensors being in the order of their names:

- eval: outputs in evaluation mode; eval_8: those with an array of 8 elements;
- power: the shares by direction behind eval;
- train: the output of the first training step, before it moves anything;
- losses: of each of three training steps;
- gradients: of the first step, a row a learnt tensor: norm, then the gradient at four sampled elements;
- input_gradients: of the first step, a row of the same kind;
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

KINDS, BOUNCES, FEATURES, NUMBERS, DIRECTIONS = 5, 2, 14, 4, 180
WAYS = KINDS * (BOUNCES + 1)
HIDDEN, FURTHER, WIDTH, BLOCKS, SIZE = 48, 8, 64, 3, 7
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


class Ways(nn.Module):
    """Logarithm of the strength and further values of each way: (..., way, feature) to (..., way, 1 + FURTHER)."""

    def __init__(self):
        super().__init__()
        self.embed = nn.Linear(FEATURES, HIDDEN, bias=False)
        self.kind = nn.Parameter(torch.zeros(WAYS, HIDDEN))
        self.hidden = nn.Linear(HIDDEN, HIDDEN)
        self.out = nn.Linear(HIDDEN, 1 + FURTHER)

    def forward(self, x):
        x = F.gelu(self.embed(x) + self.kind)
        return self.out(F.gelu(self.hidden(x)))


class Block(nn.Module):
    """Mixes directions: (link, direction, channel)."""

    def __init__(self, dilation):
        super().__init__()
        self.reach = dilation * (SIZE // 2)
        self.depthwise = nn.Conv1d(WIDTH, WIDTH, SIZE, dilation=dilation, groups=WIDTH, bias=False)
        self.norm = nn.BatchNorm1d(WIDTH)
        self.expand = nn.Linear(WIDTH, 2 * WIDTH)
        self.contract = nn.Linear(2 * WIDTH, WIDTH)
        self.gate = nn.Linear(WIDTH, WIDTH)

    def forward(self, x):
        y = F.pad(x.transpose(1, 2), (self.reach, self.reach), mode="circular")
        y = self.norm(self.depthwise(y)).transpose(1, 2)
        y = self.contract(F.gelu(self.expand(y)))
        return x + y * torch.sigmoid(self.gate(x.mean(1)))[:, None]


class PolarReg(nn.Module):
    def __init__(self, response):
        super().__init__()
        self.ways = Ways()
        self.project = nn.Linear(WAYS * FURTHER + NUMBERS + 1, WIDTH, bias=False)
        self.norm = nn.BatchNorm1d(WIDTH)
        self.blocks = nn.ModuleList([Block(1 << n % 3) for n in range(BLOCKS)])
        self.head = nn.Linear(WIDTH, 1)
        # Follows from the array's description.
        self.register_buffer("array", response, persistent=False)

    def power(self, x):
        """Share of the power by direction (link, direction)."""
        ways, numbers = x[..., : WAYS * FEATURES].unflatten(2, (WAYS, FEATURES)), x[..., WAYS * FEATURES :]
        found = self.ways(ways)
        strength = torch.logsumexp(6 * found[..., 0] + torch.log(ways[..., 0] + 0.01), 2, keepdim=True)
        further = (found[..., 1:] * ways[..., 1:2]).flatten(2)
        x = self.project(torch.cat([further, numbers, strength], 2))
        x = F.relu(self.norm(x.transpose(1, 2))).transpose(1, 2)
        for block in self.blocks:
            x = block(x)
        return torch.softmax((strength + self.head(x))[..., 0], 1)

    def forward(self, x):
        spectrum = self.power(x) @ self.array.T
        spectrum = spectrum / (spectrum.amax(1, keepdim=True) + 1e-9)
        return (spectrum - MEAN) / DEVIATION


def loss_of(y, a):
    cosine = (y * a).sum(1) / torch.sqrt((y * y).sum(1) * (a * a).sum(1) + 1e-12)
    return (y - a).abs().mean() + (1 - cosine).mean()


def inputs():
    """Numbers between -1 and 1; features between 0 and 1, half of the ways not there and all 0, feature 1 being 1 elsewhere."""
    ways = values("ways", BATCH * DIRECTIONS * WAYS * FEATURES).reshape(BATCH, DIRECTIONS, WAYS, FEATURES)
    numbers = values("numbers", BATCH * DIRECTIONS * NUMBERS).reshape(BATCH, DIRECTIONS, NUMBERS)
    is_there = ways[..., 1:2] > 0
    ways = np.where(is_there, np.abs(ways), 0.0)
    ways[..., 1:2] = is_there
    return torch.from_numpy(np.concatenate([ways.reshape(BATCH, DIRECTIONS, -1), numbers], 2))


def targets():
    """Standardised spectra with maximum 1, most of them low."""
    power = ((values("spectra", BATCH * BINS) + 1) / 2).reshape(BATCH, BINS) ** 4
    return torch.from_numpy((power / power.max(1, keepdims=True) - MEAN) / DEVIATION)


def train(net, x, a):
    out = {"losses": []}
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)
    x.requires_grad_()
    net.train()
    for step in range(3):
        y = net(x)
        loss = loss_of(y, a)
        optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["train"], out["gradients"] = y.detach().numpy(), gradients(net)
            out["input_gradients"] = np.array([row("input", x.grad)])
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        out["losses"].append(loss.item())
    out["after"] = tensors(net)
    return out


def main():
    OUT.mkdir(exist_ok=True)
    net = set_weights(PolarReg(array_response(16)))
    x = inputs()
    out = {"array": np.array([row("array", net.array)])}
    net.eval()
    with torch.no_grad():
        out["power"], out["eval"] = net.power(x).numpy(), net(x).numpy()
        of_16, net.array = net.array, array_response(8)
        out["eval_8"] = net(x).numpy()
        net.array = of_16
    out |= train(net, x, targets())
    save(OUT / "polar_reg.safetensors", out)
    count = sum(p.numel() for p in net.parameters())
    spread = {k: f"{out[k].std():.3g} {abs(out[k][0] - out[k][1]).mean():.3g}" for k in ("power", "eval", "eval_8", "train")}
    print(count, "values; std and difference of the links:", spread, "losses:", out["losses"])


if __name__ == "__main__":
    main()
