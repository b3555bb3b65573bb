"""Small files of torch.save for the tests of aps-model's reader, written by PyTorch 2.15.

    python3 weights.py

writes weights/*.pt beside this file: a linear layer 3 -> 2 (`fc`) and a batch normalisation of 2 channels (`bn`). Element i
of the k-th tensor, in the order of state_dict(), is k + i / 8.
"""

import argparse
from collections import OrderedDict
from pathlib import Path

import numpy as np
import torch
from torch import nn

OUT = Path(__file__).parent / "weights"


class Tiny(nn.Module):
    def __init__(self):
        super().__init__()
        self.fc = nn.Linear(3, 2)
        self.bn = nn.BatchNorm1d(2)


def filled():
    state = OrderedDict()
    for k, (name, t) in enumerate(Tiny().state_dict().items()):
        values = k + torch.arange(t.numel()) / 8
        state[name] = values.reshape(t.shape).to(t.dtype)
    return state


def main():
    OUT.mkdir(exist_ok=True)
    state = filled()
    torch.save(state, OUT / "plain.pt")

    # What training scripts keep: the optimizer, numbers, options, random states, all to be passed over.
    net = Tiny()
    optimizer = torch.optim.AdamW(net.parameters())
    net.bn(net.fc(torch.ones(4, 3))).square().sum().backward()
    optimizer.step()
    checkpoint = {
        "epoch": 3,
        "best": 0.125,
        "args": argparse.Namespace(lr=3e-4, name="tiny", resume=None),
        "history": [1.0, np.float64(0.5), 10**20, {"a": (1, 2, 3, 4)}],
        "rng": torch.get_rng_state(),
        "optimizer": optimizer.state_dict(),
        "r_state_dict": {"other.weight": torch.zeros(1)},
        "p_state_dict": OrderedDict((f"module.{name}", t) for name, t in state.items()),
    }
    torch.save(checkpoint, OUT / "checkpoint.pt")

    # Views of other layouts and types, and parameters instead of plain tensors.
    odd = OrderedDict(state)
    block = torch.full((5, 4), -1.0)
    block[1:4, 1:3] = state["fc.weight"].t()
    odd["fc.weight"] = block[1:4, 1:3].t()
    odd["fc.bias"] = nn.Parameter(state["fc.bias"].double())
    odd["bn.weight"] = state["bn.weight"].half()
    odd["bn.bias"] = state["bn.bias"].bfloat16()
    torch.save(odd, OUT / "layouts.pt")

    # No state dict at all.
    torch.save({"loss": 0.5, "fc.weight": state["fc.weight"]}, OUT / "no_state_dict.pt")


if __name__ == "__main__":
    main()
