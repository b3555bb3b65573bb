"""Golden values for the losses and optimizers of aps-model, computed by PyTorch in float32.

    python3 tests/golden/optimizers.py > tests/golden/optimizers.json

Weights and gradients follow closed forms that the test repeats, so that only results are stored. Made with torch 2.15.
"""

import json

import torch

SHAPES = {"a": (3, 5), "b": (7,)}
STEPS = 12


def start(name, n):
    """First values of a variable: between -1 and 1."""
    return [((7 * i + len(name) + ord(name)) % 11 - 5) / 5 for i in range(n)]


def gradient(name, n, step):
    """Its gradient at a step, in float64; longer than 1 at some steps, shorter at others."""
    scale = 0.75 if step % 3 == 0 else 0.05
    return [scale * ((3 * i + 5 * step + ord(name)) % 13 - 6) / 6 for i in range(n)]


def trajectory(make):
    variables = {}
    for name, shape in SHAPES.items():
        count = torch.Size(shape).numel()
        variables[name] = torch.tensor(start(name, count)).reshape(shape).requires_grad_()
    optimizer = make(list(variables.values()))
    norms, weights = [], {}
    for step in range(STEPS):
        for name, variable in variables.items():
            values = gradient(name, variable.numel(), step)
            variable.grad = torch.tensor(values).reshape(variable.shape)
        norms.append(torch.nn.utils.clip_grad_norm_(variables.values(), 1.0).item())
        optimizer.step()
        if step in (0, 2, STEPS - 1):
            weights[step + 1] = {n: v.detach().flatten().tolist() for n, v in variables.items()}
    return {"norms": norms, "weights": weights}


def losses():
    x = torch.tensor([-1e4, -30.0, -2.5, -1e-3, 0.0, 0.5, 4.0, 60.0, 1e4])
    t = torch.tensor([0.0, 1.0, 0.25, 1.0, 0.0, 0.5, 4.0, 0.0, 1.0])
    cases = {
        "mse": (torch.nn.functional.mse_loss, x / 1e3, t),
        "l1": (torch.nn.functional.l1_loss, x, t),
        "bce_with_logits": (torch.nn.functional.binary_cross_entropy_with_logits, x, t.clamp(0, 1)),
    }
    out = {}
    for name, (loss, inputs, targets) in cases.items():
        inputs = inputs.clone().requires_grad_()
        value = loss(inputs, targets)
        value.backward()
        out[name] = {
            "input": inputs.tolist(),
            "target": targets.tolist(),
            "value": value.item(),
            "gradient": inputs.grad.tolist(),
        }
    return out


print(
    json.dumps(
        {
            "adam": trajectory(lambda v: torch.optim.Adam(v, lr=2e-2, betas=(0.5, 0.999))),
            "adamw": trajectory(lambda v: torch.optim.AdamW(v, lr=3e-2, weight_decay=0.1)),
            "losses": losses(),
        },
        indent=1,
    )
)
