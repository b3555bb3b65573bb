"""Golden values for aps-model, from PyTorch's and torchvision's own layers in double precision.

    python3 models.py [NAME ...]

writes one file a model into models/ beside this file (all models without NAME).
The models are those of the Python package (python/map2aps/torch/models.py). Weights, images and targets follow from a hash of a name and an index, the same in the tests, so none is stored.

The arrays of a file, rows of tensors being in the order of their names:

- eval_64, eval_256: outputs in evaluation mode for images of 64 and 256 px;
- train_64: the output of the first training step, before it moves anything;
- losses: of each of three training steps (of the adversarial models: of the predictor);
- gradients: of the first step, a row a learnt tensor: norm, then the gradient at four sampled elements;
- after: all tensors after the third step, a row each: norm, then four sampled elements;
- critic_eval_64, critic_losses, critic_gradients, critic_after: the same of the regularizer.

A step is one batch of two samples, gradients clipped to norm 1. MSE and AdamW (3e-4, weight decay 0.01), or the adversarial
step: the regularizer's Adam on BCE(R(c, a), 1) + BCE(R(c, P(c)), 0) with P(c) detached, then the predictor's on
BCE(R(c, P(c)), 1) + 100 L1(P(c), a), both with 2e-4 and (0.5, 0.999). Dropout is off.
"""

import importlib.util
import json
import struct
import sys
from pathlib import Path

import numpy as np
import torch
import torch.nn.functional as F
from torch import nn

OUT = Path(__file__).parent / "models"
DEFINITIONS = Path(__file__).parents[2] / "python" / "map2aps" / "torch" / "models.py"
BINS = 180
BATCH = 2
SAMPLES = 4

# ---------------------------------------------------------------- closed-form values


def fnv1a(name):
    """Hash of a name."""
    h = 0xCBF29CE484222325
    for byte in name.encode():
        h = (h ^ byte) * 0x100000001B3 & 0xFFFFFFFFFFFFFFFF
    return h


def mix(name, count):
    """SplitMix64 of name and index: one 64-bit number an element."""
    with np.errstate(over="ignore"):
        z = np.uint64(fnv1a(name)) + np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return z ^ (z >> np.uint64(31))


def values(name, count):
    """Uniform in [-1, 1), multiples of 2^-23."""
    return (mix(name, count) >> np.uint64(40)).astype(np.float64) * 2.0**-23 - 1.0


def weights(name, shape):
    """Value of the tensor of that name, rounded to single precision."""
    last = name.rsplit(".", 1)[-1]
    if last == "num_batches_tracked":
        return np.zeros(shape, np.int64)
    u = values(name, int(np.prod(shape)))
    if last == "running_var":
        w = 1.0 + 0.5 * u
    elif len(shape) == 1 and last == "weight":
        w = 1.0 + 0.2 * u
    elif len(shape) == 1 or last in ("class_token", "pos_embedding"):
        w = 0.1 * u
    else:
        # The blocks of the U-Net have no shortcut beside them: there, make up for what ReLU halves.
        gain = 6.0 if ".block." in name else 3.0
        w = np.sqrt(gain / int(np.prod(shape[1:]))) * u
    return w.reshape(shape).astype(np.float32)


def images(size):
    """Condition images: blocks of buildings, and two bumps."""
    out = np.zeros((BATCH, 3, size, size))
    blocks = values("blocks", BATCH * (size // 8) ** 2).reshape(BATCH, size // 8, size // 8) > 0.0
    out[:, 0] = blocks.repeat(8, 1).repeat(8, 2)
    ends = np.floor((values("ends", BATCH * 4) + 1.0) / 2.0 * size).reshape(BATCH, 2, 2)
    at = np.arange(size)
    for b in range(BATCH):
        for c in range(2):
            x, y = ends[b, c]
            distance2 = (at[None, :] - x) ** 2 + (at[:, None] - y) ** 2
            out[b, 1 + c] = 1.0 / (1.0 + distance2 / 100.0)
    return torch.from_numpy(out.astype(np.float32)).double()


def targets():
    return torch.from_numpy(values("targets", BATCH * BINS).reshape(BATCH, BINS) * 2.0)


def set_weights(module):
    state = {name: torch.from_numpy(weights(name, tuple(t.shape))) for name, t in module.state_dict().items()}
    module.load_state_dict(state, strict=True)
    return module.double()


# ---------------------------------------------------------------- models


def definitions():
    """The models as the Python package has them, read without its native part."""
    spec = importlib.util.spec_from_file_location("torch_models", DEFINITIONS)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MODELS = definitions().MODELS
Regularizer = definitions().Regularizer


def without_dropout(net):
    for module in net.modules():
        if isinstance(module, nn.Dropout):
            module.p = 0.0
    return net


ADVERSARIAL = ("ms_areg", "adv_mlp")

# ---------------------------------------------------------------- what is stored


def row(name, tensor):
    """Norm and sampled elements."""
    flat = tensor.detach().double().reshape(-1).numpy()
    at = mix("sample " + name, SAMPLES) % np.uint64(len(flat))
    return [np.linalg.norm(flat), *flat[at.astype(np.int64)]]


def gradients(module):
    return np.array([row(name, p.grad) for name, p in sorted(module.named_parameters())])


def tensors(module):
    return np.array([row(name, t) for name, t in sorted(module.state_dict().items())])


def train(net, x, a):
    out = {"losses": []}
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)
    net.train()
    for step in range(3):
        y = net(x)
        loss = F.mse_loss(y, a)
        optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["train_64"], out["gradients"] = y.detach().numpy(), gradients(net)
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        out["losses"].append(loss.item())
    out["after"] = tensors(net)
    return out


def train_adversarially(net, critic, x, a):
    out = {"losses": [], "critic_losses": []}
    adam = lambda module: torch.optim.Adam(module.parameters(), lr=2e-4, betas=(0.5, 0.999))
    optimizer, critic_optimizer = adam(net), adam(critic)
    real, fake = torch.ones(BATCH, 1).double(), torch.zeros(BATCH, 1).double()
    bce = F.binary_cross_entropy_with_logits
    net.train(), critic.train()
    for step in range(3):
        y = net(x)
        loss = bce(critic(x, a), real) + bce(critic(x, y.detach()), fake)
        critic_optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["train_64"], out["critic_gradients"] = y.detach().numpy(), gradients(critic)
        nn.utils.clip_grad_norm_(critic.parameters(), 1.0)
        critic_optimizer.step()
        out["critic_losses"].append(loss.item())

        loss = bce(critic(x, y), real) + 100.0 * F.l1_loss(y, a)
        optimizer.zero_grad()
        loss.backward()
        if step == 0:
            out["gradients"] = gradients(net)
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        out["losses"].append(loss.item())
    out["after"], out["critic_after"] = tensors(net), tensors(critic)
    return out


def save(path, arrays):
    """Safetensors by hand: a JSON header and the bytes."""
    header, data = {}, b""
    for name, array in arrays.items():
        array = np.ascontiguousarray(array, np.float64)
        header[name] = {"dtype": "F64", "shape": array.shape, "data_offsets": [len(data), len(data) + array.nbytes]}
        data += array.tobytes()
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + data)


def main(names):
    OUT.mkdir(exist_ok=True)
    a = targets()
    for name in names:
        net = set_weights(without_dropout(MODELS[name]("paper")))
        count = sum(p.numel() for p in net.parameters())
        out = {}
        net.eval()
        with torch.no_grad():
            out["eval_64"], out["eval_256"] = net(images(64)).numpy(), net(images(256)).numpy()
        if name in ADVERSARIAL:
            critic = set_weights(Regularizer(64)).eval()
            with torch.no_grad():
                out["critic_eval_64"] = critic(images(64), a).numpy()
            out |= train_adversarially(net, critic, images(64), a)
        else:
            out |= train(net, images(64), a)
        save(OUT / f"{name}.safetensors", out)
        spread = {k: f"{out[k].std():.3g} {abs(out[k][0] - out[k][-1]).mean():.3g}" for k in ("eval_64", "eval_256", "train_64")}
        print(name, count, "std and difference of samples:", spread, "losses:", out["losses"], out.get("critic_losses"))


if __name__ == "__main__":
    main(sys.argv[1:] or MODELS)
