"""Names and shapes of torchvision's state dicts, and small files of torch.save with the names that wrappers of modules leave,
for the tests of aps-model's reader. Written by PyTorch 2.15 and torchvision 0.29.

    python3 torchvision_names.py

writes beside this file weights/torchvision_*.json, one tensor a line, and weights/wrapped_*.pt, each of the module and the
values of weights.py. torchvision itself is asked whether it loads the files of its earlier releases.
"""

import json

import torch
import torchvision
from torch import nn
from torch.optim.swa_utils import AveragedModel

from weights import OUT, Tiny, filled


def write(name, state):
    lines = [f"{json.dumps(key)}: {json.dumps(list(t.shape))}" for key, t in state.items()]
    (OUT / f"torchvision_{name}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


def lists():
    resnet = torchvision.models.resnet18().state_dict()
    write("resnet18", resnet)
    # Files of before PyTorch 0.4.1, as torchvision still offers them, have no counters.
    old = {k: t for k, t in resnet.items() if not k.endswith("num_batches_tracked")}
    torchvision.models.resnet18().load_state_dict(old)
    write("resnet18_old", old)

    vit = torchvision.models.vit_b_16().state_dict()
    write("vit_b_16", vit)
    old = {
        k.replace(".mlp.0.", ".mlp.linear_1.").replace(".mlp.3.", ".mlp.linear_2."): t for k, t in vit.items()
    }
    torchvision.models.vit_b_16().load_state_dict(old)
    write("vit_b_16_old", old)


class Outer(nn.Module):
    """A module that has the model as an attribute, beside others: Lightning's form."""

    def __init__(self, model):
        super().__init__()
        self.model = model
        self.loss = nn.Linear(1, 1)


def wrapped():
    net = Tiny()
    net.load_state_dict(filled())
    parallel, compiled = nn.DataParallel, torch.compile
    torch.save(compiled(parallel(net)).state_dict(), OUT / "wrapped_compiled_parallel.pt")
    torch.save(parallel(compiled(parallel(net))).state_dict(), OUT / "wrapped_thrice.pt")
    # An average counts its models beside the module.
    torch.save(AveragedModel(net).state_dict(), OUT / "wrapped_averaged.pt")
    outer = {"epoch": 3, "state_dict": Outer(compiled(net)).state_dict(), "hyper_parameters": {"lr": 1e-3}}
    torch.save(outer, OUT / "wrapped_attribute.pt")
    # An unusual key, and an optimizer whose state goes by names.
    names = {name: {"step": torch.tensor(3.0)} for name in net.state_dict()}
    odd = {"weights_now": net.state_dict(), "optimizer": {"state": names}, "epoch": 3}
    torch.save(odd, OUT / "wrapped_odd_key.pt")
    # A part alone is compiled.
    net.fc = compiled(net.fc)
    torch.save({"net": net.state_dict()}, OUT / "wrapped_part.pt")
    twice = {"student": filled(), "teacher": filled()}
    torch.save(twice, OUT / "wrapped_two_copies.pt")
    torch.save({"model": filled(), "model_ema": filled()}, OUT / "wrapped_with_average.pt")
    torch.save({"model": Tiny(), "epoch": 3}, OUT / "wrapped_module.pt")


if __name__ == "__main__":
    lists()
    wrapped()
