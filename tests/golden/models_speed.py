"""Time of training steps and of inference: PyTorch on the CPU and aps-model, in turns, in one run.

    python3 models_speed.py [--threads 2] [--rounds 5] [CASE ...]

A case is MODEL-WHAT-PIXELS-BATCH, like ms_areg-train-64-32. Prints the best time of each [ms a sample] and their ratio.
Both sides hold the same layers (models.py beside this file, in f32 here) and do the same step: forward, loss, backward,
gradient norm clipped at 1, optimizer; the adversarial models both of their steps.
aps-model's side is the example `step_time` of the crate, built first. Rounds alternate, so that both sides meet the same
machine; the best counts, since everything else the machine does only adds.
"""

import argparse
import os
import subprocess
import time
from pathlib import Path

import torch
import torch.nn.functional as F
from torch import nn

import models

ROOT = Path(__file__).parents[2]
CASES = """resnet_mlp-train-64-32 resnet_mlp-train-128-16 resnet_mlp-infer-64-32 resnet_mlp-infer-128-16
ms_areg-train-64-32 ms_areg-train-128-16 ms_areg-infer-64-32 radiounet-train-64-8 radiounet-infer-64-8
vit_reg-train-64-4 vit_reg-infer-64-4 resnet_conv1d-train-64-32 resnet_conv1d-infer-64-32""".split()


def regression_step(net, x, a):
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)

    def step():
        loss = F.mse_loss(net(x), a)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        return loss.item()

    return step


def adversarial_step(net, x, a):
    critic = models.Regularizer().train()
    adam = lambda module: torch.optim.Adam(module.parameters(), lr=2e-4, betas=(0.5, 0.999))
    optimizer, critic_optimizer = adam(net), adam(critic)
    bce = F.binary_cross_entropy_with_logits
    real, fake = torch.ones(len(x), 1), torch.zeros(len(x), 1)

    def learn(loss, module, optimizer):
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(module.parameters(), 1.0)
        optimizer.step()
        return loss.item()

    def step():
        y = net(x)
        learn(bce(critic(x, a), real) + bce(critic(x, y.detach()), fake), critic, critic_optimizer)
        return learn(bce(critic(x, y), real) + 100.0 * F.l1_loss(y, a), net, optimizer)

    return step


def torch_case(name):
    model, what, pixels, batch = name.split("-")
    torch.manual_seed(1)
    net = models.MODELS[model]()
    x, a = torch.rand(int(batch), 3, int(pixels), int(pixels)), torch.randn(int(batch), models.BINS)
    if what == "infer":
        net.eval()

        def infer():
            with torch.inference_mode():
                return net(x)

        return infer
    net.train()
    return (adversarial_step if model in models.ADVERSARIAL else regression_step)(net, x, a)


def best_ms(run, seconds=3.0):
    run(), run()
    best, started = float("inf"), time.perf_counter()
    while time.perf_counter() - started < seconds:
        t = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - t)
    return best * 1e3


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", nargs="*", default=CASES)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    build = ["cargo", "build", "--release", "--package", "aps-model", "--example", "step_time"]
    subprocess.run(build, cwd=ROOT, check=True)
    program = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/examples/step_time"
    # As the runner sets them.
    environment = os.environ | {"RAYON_NUM_THREADS": str(args.threads), "MIMALLOC_PURGE_DELAY": "-1"}

    def ours(case):
        return float(subprocess.run([program, case], env=environment, check=True, capture_output=True).stdout)

    print(f"torch {torch.__version__}, {args.threads} threads, ms a sample, best of {args.rounds} rounds")
    for case in args.cases:
        run, batch = torch_case(case), int(case.split("-")[3])
        pairs = [(best_ms(run), ours(case)) for _ in range(args.rounds)]
        theirs, mine = (min(side) / batch for side in zip(*pairs))
        print(f"{case:28} PyTorch {theirs:8.2f}   aps-model {mine:8.2f}   ratio {mine / theirs:5.2f}", flush=True)


if __name__ == "__main__":
    main()
