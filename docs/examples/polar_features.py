"""Takes one thing after the other away from Polar-Reg, trains each variant on the same batches, and prints what it costs.

    python docs/examples/polar_features.py DATA [MAPS]

DATA is a data set of the protocol paper, MAPS the maps that it was made from, unless they are synthetic. The variants learn together,
step by step, so that the geometry of a batch is found once for all. Needs map2aps with torch, and tqdm for the bar.
"""

import argparse

import numpy as np
import torch
from torch import nn
from tqdm import tqdm

import map2aps
from map2aps.torch import ApsDataset, models

FEATURES = models.POLAR_FEATURES
# Kinds of ways: straight, over one corner (lit straight, after one reflection, after two), over several; each by bounces.
KINDS, BOUNCES = 5, 3
PART = 16  # links in a row that a batch takes together: most are of one transmitter


class Without:
    """Takes kinds of ways, or features of all, out of a batch."""

    def __init__(self, kinds=(), bounces=(), features=()):
        kept = torch.ones(KINDS, BOUNCES)
        kept[list(kinds)] = 0
        kept[:, list(bounces)] = 0
        self.kept = kept.flatten()
        self.factor = torch.ones(FEATURES + 2)
        self.factor[list(features)] = 0

    def __call__(self, ways):
        return ways * self.factor * self.kept[ways[..., -1].long()].unsqueeze(-1)


def absolute(found, wanted):
    return (found - wanted).abs().mean()


def cosine(found, wanted):
    return 1 - nn.functional.cosine_similarity(found, wanted).mean()


def both(found, wanted):
    return absolute(found, wanted) + cosine(found, wanted)


VARIANTS = {
    "nothing": (Without(), both),
    "ways that arrive after a bounce": (Without(bounces=(1, 2)), both),
    "ways that arrive after two bounces": (Without(bounces=(2,)), both),
    "ways over a corner lit after reflections": (Without(kinds=(2, 3)), both),
    "ways over several corners": (Without(kinds=(4,)), both),
    "all ways over corners": (Without(kinds=(1, 2, 3, 4)), both),
    "angle between ray and way": (Without(features=(0, 2)), both),
    "turns at corners": (Without(features=(4, 5)), both),
    "lengths": (Without(features=(3, 6, 11)), both),
    "cosines of incidence at walls": (Without(features=(8, 9, 10)), both),
    "angles to the corner's bisector": (Without(features=(12, 13)), both),
    "the cosine in the loss": (Without(), absolute),
    "the absolute difference in the loss": (Without(), cosine),
}


def built(statistics):
    torch.manual_seed(1)
    model = models.build("polar_reg")
    model.fixed.array.copy_(models.shipped("polar_reg").fixed.array)
    model.fixed.mean.fill_(statistics[0])
    model.fixed.deviation.fill_(statistics[1])
    return model


def parts(examples, links, generator):
    """Numbers of examples, without end: parts of links in a row, each link in one of its four mirror images."""
    starts = np.arange(0, len(examples) // 4 - PART, PART)
    while True:
        together = links // PART
        for chosen in generator.permutation(starts)[: len(starts) // together * together].reshape(-1, together):
            rows = (chosen[:, None] + np.arange(PART)).ravel()
            yield 4 * rows + generator.integers(4, size=len(rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data")
    parser.add_argument("maps", nargs="?")
    parser.add_argument("--steps", type=int, default=1440)
    parser.add_argument("--batch", type=int, default=32, help="links a step, a multiple of 16")
    parser.add_argument("--rate", type=float, default=6e-3, help="highest learning rate")
    parser.add_argument("--links", type=int, default=3000, help="links of the development maps to score")
    parser.add_argument("--seed", type=int, default=1, help="of the batches")
    args = parser.parse_args()
    of = {"condition": "polar", "maps": args.maps}
    train, develop = ApsDataset(args.data, "train", **of), ApsDataset(args.data, "develop", **of)
    numbers = np.linspace(0, len(develop) - 1, args.links).astype(int)
    (_, truth), (_, power) = (ApsDataset(args.data, "develop", domain=domain).batch(numbers) for domain in ("normalised", "linear"))
    deviation = float(power.std() / truth.std())
    statistics = float(power.mean()) - deviation * float(truth.mean()), deviation

    variants = []
    for name, (without, loss) in VARIANTS.items():
        model = built(statistics).train()
        learnt = [p for p in model.parameters() if p.requires_grad]
        optimizer = torch.optim.AdamW(learnt, lr=args.rate)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, args.rate, total_steps=args.steps, pct_start=0.1)
        variants.append((name, without, loss, model, learnt, optimizer, schedule))
    batches = parts(train, args.batch, np.random.default_rng(args.seed))
    for _ in tqdm(range(args.steps)):
        ways, wanted = train.batch(next(batches))
        for name, without, loss, model, learnt, optimizer, schedule in variants:
            optimizer.zero_grad()
            loss(model(without(ways)), wanted).backward()
            nn.utils.clip_grad_norm_(learnt, 1.0)
            optimizer.step()
            schedule.step()

    print(f"{args.steps} steps of {args.batch} links, {args.links} links of development maps\n\n| without | CosSim | MAE |\n|---|---|---|")
    for name, without, _, model, *_ in variants:
        model.eval()
        with torch.no_grad():
            found = torch.cat([model(without(develop.batch(some)[0])) for some in np.array_split(numbers, max(1, args.links // 250))])
        scores = map2aps.metrics(truth.numpy(), found.numpy(), "paper").summary
        print(f"| {name} | {scores['cosine']:.3f} | {scores['mae']:.3f} |")


if __name__ == "__main__":
    main()
