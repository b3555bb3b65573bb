"""Measures the error of PyTorch's own autocast to bf16 against f32: the yardstick of the tests of mixed precision (crates/aps-model/src/tests/mixed.rs).

    python tests/golden/mixed.py     # needs map2aps with torch

For each small model with random weights, of spectra in use and of all gradients in training (16 links, 64 px, no dropout): the length
of the difference over the length of what f32 gives.
"""

import torch
from torch import nn

from map2aps.torch import models

LINKS = 16


def main() -> None:
    generator = torch.Generator().manual_seed(1)
    ways = torch.rand(LINKS, 220, 16, generator=generator)
    ways[..., 1], ways[..., 14], ways[..., 15] = 1.0, ways[..., 14].mul(720).floor(), ways[..., 15].mul(15).floor()
    images, targets = (torch.rand(LINKS, *shape, generator=generator) for shape in ((3, 64, 64), (180,)))
    for name in models.MODELS:
        torch.manual_seed(3)
        model = models.build(name, "small")
        for module in model.modules():
            if isinstance(module, nn.Dropout):
                module.p = 0.0
        if name == "polar_reg":
            model.fixed.array.uniform_(0, 1)
        conditions = ways if name == "polar_reg" else images

        def spectra(is_mixed: bool) -> torch.Tensor:
            with torch.autocast("cpu", torch.bfloat16, enabled=is_mixed):
                return model(conditions).float()

        def gradients(is_mixed: bool) -> torch.Tensor:
            model.zero_grad()
            nn.functional.mse_loss(spectra(is_mixed), targets).backward()
            return torch.cat([p.grad.flatten() for p in model.parameters() if p.grad is not None])

        found = []
        for of in (spectra, gradients):
            model.train(of is gradients)
            full, mixed = of(False).detach(), of(True).detach()
            found.append(float((mixed - full).norm() / full.norm()))
        print(f"{name}: spectra {found[0]:.1e}, gradients {found[1]:.1e}")


if __name__ == "__main__":
    main()
