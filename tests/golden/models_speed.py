"""Time of training steps and of inference: PyTorch and aps-model, in turns, in one run.

    python3 models_speed.py [--threads 2] [--rounds 5] [--device cpu|cuda] [--precision full mixed] [CASE ...]

A case is MODEL-WHAT-PIXELS-BATCH, like ms_areg-train-64-32. Prints the best time of each [ms a link] and their ratio.
Both sides hold the same layers (models.py beside this file, in f32 here) and do the same step: forward, loss, backward,
gradient norm clipped at 1, optimizer; the adversarial models both of their steps. Mixed precision is autocast to bf16 on one side,
`Precision::Mixed` on the other.
aps-model's side is the example `step_time` of the crate, built first unless `--program` names it. Rounds alternate, so that both sides
meet the same machine; the best counts, since everything else the machine does only adds.
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


def computing_in(module, is_mixed):
    """The module, whose results are made under autocast if `is_mixed`."""
    forward = module.forward

    def cast(*inputs):
        with torch.autocast(inputs[0].device.type, torch.bfloat16, enabled=is_mixed):
            return forward(*inputs)

    module.forward = cast
    return module


def regression_step(net, x, a, is_mixed):
    optimizer = torch.optim.AdamW(net.parameters(), lr=3e-4, weight_decay=0.01)

    def step():
        loss = F.mse_loss(net(x).float(), a)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimizer.step()
        return loss.item()

    return step


def adversarial_step(net, x, a, is_mixed):
    critic = computing_in(models.definitions().Regularizer(64).to(x.device).train(), is_mixed)
    adam = lambda module: torch.optim.Adam(module.parameters(), lr=2e-4, betas=(0.5, 0.999))
    optimizer, critic_optimizer = adam(net), adam(critic)
    bce = F.binary_cross_entropy_with_logits
    real, fake = torch.ones(len(x), 1, device=x.device), torch.zeros(len(x), 1, device=x.device)

    def learn(loss, module, optimizer):
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(module.parameters(), 1.0)
        optimizer.step()
        return loss.item()

    def step():
        y = net(x).float()
        score = lambda y: critic(x, y).float()
        learn(bce(score(a), real) + bce(score(y.detach()), fake), critic, critic_optimizer)
        return learn(bce(score(y), real) + 100.0 * F.l1_loss(y, a), net, optimizer)

    return step


def torch_case(name, device, is_mixed):
    model, what, pixels, batch = name.split("-")
    torch.manual_seed(1)
    net = models.MODELS[model]("paper").to(device)
    x, a = torch.rand(int(batch), 3, int(pixels), int(pixels), device=device), torch.randn(int(batch), models.BINS, device=device)
    computing_in(net, is_mixed)
    if what == "infer":
        net.eval()

        def infer():
            with torch.inference_mode():
                net(x)
            if device == "cuda":
                torch.cuda.synchronize()

        return infer
    return (adversarial_step if model in models.ADVERSARIAL else regression_step)(net.train(), x, a, is_mixed)


def best_ms(run, seconds):
    run(), run()
    best, started = float("inf"), time.perf_counter()
    while time.perf_counter() - started < seconds:
        t = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - t)
    return best * 1e3


def built():
    build = ["cargo", "build", "--release", "--package", "aps-model", "--example", "step_time"]
    subprocess.run(build, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release/examples/step_time"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", nargs="*", default=CASES)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=3.0, help="time of a case, on each side")
    parser.add_argument("--device", default="cpu", choices=["cpu", "cuda"])
    parser.add_argument("--precision", nargs="+", default=["full"], choices=["full", "mixed"])
    parser.add_argument("--program", help="step_time, built elsewhere")
    args = parser.parse_args()
    torch.set_num_threads(args.threads)
    # f32 is f32 on both sides.
    torch.backends.cudnn.allow_tf32 = False
    program = args.program or built()
    # As the runner sets them.
    environment = os.environ | {"RAYON_NUM_THREADS": str(args.threads), "MIMALLOC_PURGE_DELAY": "-1"}

    def ours(case, precision):
        words = [program, case, args.device, precision, str(args.seconds)]
        return float(subprocess.run(words, env=environment, check=True, stdout=subprocess.PIPE).stdout)

    print(f"torch {torch.__version__}, {args.device}, {args.threads} threads, ms a link, best of {args.rounds} rounds\n")
    print("| case | precision | PyTorch | aps-model | ratio |\n|---|---|---|---|---|")
    failed = []
    for case in args.cases:
        for precision in args.precision:
            batch = int(case.split("-")[3])
            try:
                run = torch_case(case, args.device, precision == "mixed")
                pairs = [(best_ms(run, args.seconds), ours(case, precision)) for _ in range(args.rounds)]
            except (subprocess.CalledProcessError, torch.cuda.OutOfMemoryError) as error:
                failed.append(case)
                print(f"| {case} | {precision} | failed: {type(error).__name__} | | |", flush=True)
                continue
            theirs, mine = (min(side) / batch for side in zip(*pairs))
            print(f"| {case} | {precision} | {theirs:.3f} | {mine:.3f} | {mine / theirs:.2f} |", flush=True)
    if failed:
        raise SystemExit(f"failed: {' '.join(failed)}")


if __name__ == "__main__":
    main()
