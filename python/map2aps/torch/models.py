"""The models of the benchmark in PyTorch, with the names and shapes of parameters that the files of ``cargo xtask train`` have.

Each takes condition images of shape (batch, 3, height, width), Polar-Reg what `map2aps.PolarView` makes; `map2aps.torch.ApsDataset`
has both. They give spectra of shape (batch, 180) in the data set's normalised domain. All sizes but the spectrum's follow from
``width``, the channels of the first stage: 64 in the paper, 32 in the preset "small" for CPUs (16 of RadioUNet; a smaller transformer).
What is not listed in ``__all__`` are their parts.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal, TypeAlias

import torch
import torch.nn.functional as F
import torchvision
from torch import Tensor, nn
from torchvision.models.resnet import BasicBlock, ResNet

__all__ = [
    "MODELS",
    "AdvMlp",
    "MsAreg",
    "MsMlp",
    "PolarReg",
    "RadioUnet",
    "Regularizer",
    "ResnetConv1d",
    "ResnetMlp",
    "VitReg",
    "build",
    "check",
    "load",
    "save",
    "shipped",
]

BINS = 180
DROPOUT = 0.1
# Polar-Reg: directions; kinds of ways (5, after 0 to 2 bounces) and their features; width of its layers.
POLAR_DIRECTIONS, POLAR_KINDS, POLAR_FEATURES, POLAR_HIDDEN = 720, 15, 14, 48
Preset: TypeAlias = Literal["paper", "small"]


def resnet18(width: int) -> nn.Module:
    """torchvision's ResNet-18 without its last layer; its features are 8 widths."""
    net: Any = ResNet(BasicBlock, [2, 2, 2, 2])
    if width != 64:
        net.inplanes = width
        net.conv1 = nn.Conv2d(3, width, 7, stride=2, padding=3, bias=False)
        net.bn1 = nn.BatchNorm2d(width)
        for n in range(4):
            layer = net._make_layer(BasicBlock, width << n, 2, stride=1 if n == 0 else 2)
            setattr(net, f"layer{n + 1}", layer)
    net.fc = nn.Identity()
    encoder: nn.Module = net
    return encoder


def mlp(*sizes: int, last: bool = False) -> nn.Sequential:
    """A perceptron with leaky ReLU between its layers, and behind the last one if asked for."""
    layers: list[nn.Module] = []
    for a, b in zip(sizes, sizes[1:]):
        layers += [nn.Linear(a, b), nn.LeakyReLU(0.2)]
    return nn.Sequential(*(layers if last else layers[:-1]))


def decoder(inputs: int, width: int) -> nn.Sequential:
    """The perceptron that makes a spectrum of features."""
    return mlp(inputs, 16 * width, 16 * width, 8 * width, BINS)


class MultiScale(nn.Module):
    """Encoder that pools every stage of a ResNet-18: features of four scales, and 8 widths of all together.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        net: Any = resnet18(width)
        self.stem = nn.Sequential(net.conv1, net.bn1, net.relu, net.maxpool)
        self.layer1, self.layer2, self.layer3, self.layer4 = net.layer1, net.layer2, net.layer3, net.layer4
        self.pool1, self.pool2 = nn.AdaptiveAvgPool2d(4), nn.AdaptiveAvgPool2d(2)
        self.pool3, self.pool4 = nn.AdaptiveAvgPool2d(1), nn.AdaptiveAvgPool2d(1)
        self.proj1, self.proj2 = nn.Linear(16 * width, 4 * width), nn.Linear(8 * width, 4 * width)
        self.proj3, self.proj4 = nn.Linear(4 * width, 4 * width), nn.Linear(8 * width, 4 * width)
        self.global_proj = nn.Sequential(nn.Linear(16 * width, 8 * width), nn.ReLU(), nn.Linear(8 * width, 8 * width))

    def forward(self, x: Tensor) -> tuple[list[Tensor], Tensor]:
        """Features of four scales, each (batch, 4 widths), and of all together, (batch, 8 widths), of images (batch, 3, height, width)."""
        f1 = self.layer1(self.stem(x))
        f2 = self.layer2(f1)
        f3 = self.layer3(f2)
        f4 = self.layer4(f3)
        scales = [
            self.proj1(self.pool1(f1).flatten(1)),
            self.proj2(self.pool2(f2).flatten(1)),
            self.proj3(self.pool3(f3).flatten(1)),
            self.proj4(self.pool4(f4).flatten(1)),
        ]
        return scales, self.global_proj(torch.cat(scales, 1))


class MsAreg(nn.Module):
    """MS-AReg: multi-scale encoder, zeros where its generative origin had noise, decoder. Trained against a `Regularizer`.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = MultiScale(width)
        self.noise_proj = nn.Linear(2 * width, 4 * width)
        self.decoder = decoder(12 * width, width)

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        noise = self.noise_proj(x.new_zeros(len(x), self.noise_proj.in_features))
        spectrum: Tensor = self.decoder(torch.cat([self.encoder(x)[1], noise], 1))
        return spectrum


class MsMlp(nn.Module):
    """MS-MLP: MS-AReg without the regularizer.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = MultiScale(width)
        self.decoder = decoder(8 * width, width)

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        spectrum: Tensor = self.decoder(self.encoder(x)[1])
        return spectrum


class AdvMlp(nn.Module):
    """Adv-MLP: MS-AReg without the multi-scale encoder. Trained against a `Regularizer`.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = resnet18(width)
        self.noise_proj = nn.Linear(2 * width, 4 * width)
        self.decoder = decoder(12 * width, width)

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        noise = self.noise_proj(x.new_zeros(len(x), self.noise_proj.in_features))
        spectrum: Tensor = self.decoder(torch.cat([self.encoder(x), noise], 1))
        return spectrum


class Regularizer(nn.Module):
    """Tells true spectra from predicted ones, given the condition.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.cond_encoder = resnet18(width)
        self.aps_encoder = mlp(BINS, 8 * width, 4 * width, last=True)
        self.head = mlp(12 * width, 8 * width, 4 * width, 1)

    def forward(self, x: Tensor, a: Tensor) -> Tensor:
        """Judges spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.
        a : Tensor, shape (batch, 180)
            Spectra in the normalised domain.

        Returns
        -------
        Tensor, shape (batch, 1)
            Logits: above 0 for a spectrum that looks true.
        """
        logits: Tensor = self.head(torch.cat([self.cond_encoder(x), self.aps_encoder(a)], 1))
        return logits


class ResnetMlp(nn.Module):
    """ResNet-18 and a perceptron.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = resnet18(width)
        features = 8 * width
        self.head = nn.Sequential(
            nn.Linear(features, features), nn.ReLU(), nn.Dropout(DROPOUT), nn.Linear(features, BINS)
        )

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        spectrum: Tensor = self.head(self.encoder(x))
        return spectrum


class DoubleConv(nn.Module):
    """Two convolutions, each normalised and rectified."""

    def __init__(self, a: int, b: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        for i in (a, b):
            layers += [nn.Conv2d(i, b, 3, padding=1), nn.BatchNorm2d(b), nn.ReLU()]
        self.block = nn.Sequential(*layers)

    def forward(self, x: Tensor) -> Tensor:
        """Features (batch, b, height, width) of (batch, a, height, width)."""
        y: Tensor = self.block(x)
        return y


class RadioUnet(nn.Module):
    """A U-Net, averaged over the image, and a perceptron; sides of images are multiples of 16.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 16 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        sizes = [3, *(width << n for n in range(4))]
        for n in range(1, 5):
            self.add_module(f"enc{n}", DoubleConv(sizes[n - 1], sizes[n]))
            self.add_module(f"up{n}", nn.ConvTranspose2d(2 * sizes[n], sizes[n], 2, stride=2))
            self.add_module(f"dec{n}", DoubleConv(2 * sizes[n], sizes[n]))
        self.bottleneck = DoubleConv(8 * width, 16 * width)
        self.head = nn.Sequential(nn.Linear(width, 8 * width), nn.ReLU(), nn.Linear(8 * width, BINS))

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        skips = []
        for n in range(1, 5):
            skips.append(getattr(self, f"enc{n}")(x))
            x = F.max_pool2d(skips[-1], 2)
        x = self.bottleneck(x)
        for n in range(4, 0, -1):
            x = getattr(self, f"dec{n}")(torch.cat([getattr(self, f"up{n}")(x), skips[n - 1]], 1))
        spectrum: Tensor = self.head(x.mean((2, 3)))
        return spectrum


class VitReg(nn.Module):
    """A vision transformer, ViT-B/16 in the paper, and a perceptron; images of any size are brought to its own.

    Parameters
    ----------
    image_size : int
        Rows and columns of the images that the transformer sees.
    patch : int
        Rows and columns of a patch; `image_size` is a multiple.
    width : int
        Values of a token.
    depth : int
        Number of layers.
    heads : int
        Heads of a layer; `width` is a multiple.
    hidden : int
        Values of the perceptron's hidden layer.
    """

    def __init__(self, image_size: int, patch: int, width: int, depth: int, heads: int, hidden: int) -> None:
        super().__init__()
        self.image_size = image_size
        self.vit = torchvision.models.VisionTransformer(image_size, patch, depth, heads, width, 4 * width)
        self.vit.heads = nn.Identity()
        self.head = nn.Sequential(nn.Linear(width, hidden), nn.GELU(), nn.Dropout(DROPOUT), nn.Linear(hidden, BINS))

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        x = F.interpolate(x, size=(self.image_size, self.image_size), mode="bilinear", align_corners=False)
        spectrum: Tensor = self.head(self.vit(x))
        return spectrum


class Film(nn.Module):
    """Scale and shift of channels, of a condition."""

    def __init__(self, condition: int, channels: int) -> None:
        super().__init__()
        self.proj = nn.Linear(condition, 2 * channels)

    def forward(self, x: Tensor, condition: Tensor) -> Tensor:
        """Features (batch, channel, place) scaled and shifted by conditions (batch, value)."""
        gamma, beta = self.proj(condition).chunk(2, 1)
        modulated: Tensor = gamma[:, :, None] * x + beta[:, :, None]
        return modulated


class ResnetConv1d(nn.Module):
    """The multi-scale encoder and convolutions over the angle.

    Parameters
    ----------
    width : int
        Channels of the first stage: 64 in the preset "paper", 32 in "small".
    """

    def __init__(self, width: int) -> None:
        super().__init__()
        self.encoder = MultiScale(width)
        condition = 4 * width
        self.init_proj = nn.Linear(8 * width, 4 * width * (BINS // 4))
        for name, a, b in ("up1", 4 * width, 2 * width), ("up2", 2 * width, width):
            self.add_module(name + "_conv1", nn.Conv1d(a, b, 5, padding=2))
            self.add_module(name + "_bn1", nn.BatchNorm1d(b))
            self.add_module(name + "_film", Film(condition, b))
            self.add_module(name + "_conv2", nn.Conv1d(b, b, 3, padding=1))
            self.add_module(name + "_bn2", nn.BatchNorm1d(b))
        self.ref_conv1, self.ref_bn = nn.Conv1d(width, width // 2, 3, padding=1), nn.BatchNorm1d(width // 2)
        self.ref_film, self.ref_conv2 = Film(condition, width // 2), nn.Conv1d(width // 2, 1, 1)

    def upsample(self, x: Tensor, condition: Tensor, name: str) -> Tensor:
        """Doubles the number of angles.

        Parameters
        ----------
        x : Tensor, shape (batch, channels, angles)
            Features over the angle.
        condition : Tensor, shape (batch, 4 * width)
            Features of the images that scale and shift them.
        name : str
            The stage, "up1" or "up2".

        Returns
        -------
        Tensor, shape (batch, channels / 2, 2 * angles)
        """
        conv1, bn1, film, conv2, bn2 = (
            getattr(self, name + layer) for layer in ("_conv1", "_bn1", "_film", "_conv2", "_bn2")
        )
        x = F.leaky_relu(bn1(conv1(F.interpolate(x, scale_factor=2, mode="nearest"))), 0.2)
        y: Tensor = F.leaky_relu(bn2(conv2(film(x, condition))), 0.2)
        return y

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, 3, height, width)
            Condition images.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the normalised domain.
        """
        (s1, s2, s3, _), g = self.encoder(x)
        x = self.upsample(self.init_proj(g).reshape(len(g), -1, BINS // 4), s3, "up1")
        x = self.upsample(x, s2, "up2")
        x = F.leaky_relu(self.ref_bn(self.ref_conv1(x)), 0.2)
        spectrum: Tensor = self.ref_conv2(self.ref_film(x, s1))[:, 0]
        return spectrum


class PolarWays(nn.Module):
    """A sixth of the logarithm of each way's strength: (..., way, number) to (..., way)."""

    def __init__(self) -> None:
        super().__init__()
        self.embed = nn.Linear(POLAR_FEATURES + POLAR_KINDS, POLAR_HIDDEN)
        self.hidden = nn.Linear(POLAR_HIDDEN, POLAR_HIDDEN)
        self.out = nn.Linear(POLAR_HIDDEN, 1)

    def forward(self, x: Tensor) -> Tensor:
        """Values (..., way) of ways (..., way, number): features, direction, kind."""
        kinds = x[..., -1:] == torch.arange(POLAR_KINDS, device=x.device)
        x = F.gelu(self.embed(torch.cat([x[..., :POLAR_FEATURES], kinds.to(x.dtype)], -1)))
        out: Tensor = self.out(F.gelu(self.hidden(x)))[..., 0]
        return out


class PolarSpectrum(nn.Module):
    """Facts of the labels, which are given and not learnt: the array's response, and how spectra are normalised."""

    array: Tensor
    mean: Tensor
    deviation: Tensor
    is_by_link: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("array", torch.zeros(BINS, POLAR_DIRECTIONS))
        self.register_buffer("mean", torch.tensor(0.0))
        self.register_buffer("deviation", torch.tensor(1.0))
        self.register_buffer("is_by_link", torch.tensor(0.0))
        self.register_load_state_dict_post_hook(_look)  # type: ignore[no-untyped-call]
        self.is_set = False

    def forward(self, power: Tensor) -> Tensor:
        """Normalised spectra (link, bin) of power (link, direction)."""
        # Looked at once: on a GPU a look waits for all that is under way.
        if not self.is_set:
            _look(self)
        if not self.is_set:
            raise ValueError("model: nobody told it the array of the labels; build('polar_reg', data=...) or set_labels(data) does")
        y = power @ self.array.T
        y = (y / (y.amax(1, keepdim=True) + 1e-9) - self.mean) / self.deviation
        if self.is_by_link == 0:
            return y
        y = y - y.mean(1, keepdim=True)
        return y / (y.square().mean(1, keepdim=True).sqrt() + 1e-8)


def _look(spectrum: PolarSpectrum, _keys: object = None) -> None:
    """Looks if the facts of the labels are there."""
    spectrum.is_set = bool(spectrum.array.any())


def _facts(data: str | os.PathLike[str]) -> dict[str, Tensor]:
    """Facts of a data set's labels, by the names of the buffers that hold them."""
    from map2aps import _native

    facts, array = json.loads(_native.training_facts(data)), torch.from_numpy(_native.array_response(data))
    if array.shape != (BINS, POLAR_DIRECTIONS):
        raise ValueError(f"data: spectra of {len(array)} bins, the models predict {BINS}")
    statistics = facts["training_statistics"]
    numbers = {"mean": statistics["mean"], "deviation": statistics["std"], "is_by_link": float(facts["protocol"] == "released")}
    return {"array": array} | {name: torch.tensor(number, dtype=torch.float64) for name, number in numbers.items()}


class PolarReg(nn.Module):
    """Polar-Reg, which is given the geometry of ways along rays around the receiver.

    Its last step is not learnt: the response of the array that labels are of, and how they are normalised. `set_labels` takes both from a
    data set, as files of weights have them too.
    """

    def __init__(self) -> None:
        super().__init__()
        self.ways = PolarWays()
        self.fixed = PolarSpectrum()

    def set_labels(self, data: str | os.PathLike[str]) -> None:
        """Takes from a data set what the model computes with instead of learning it: the array's response, and how labels are normalised.

        Its ``settings`` are then those of the data set.

        Parameters
        ----------
        data : path-like
            Folder of the data set.

        Raises
        ------
        ValueError
            For a data set that does not tell its array, and spectra of another number of bins.
        """
        from map2aps.torch import _settings

        facts, kind = _facts(data), getattr(self, "kind", None)
        if isinstance(kind, str):
            self.settings: Any = _settings.facts_of(kind, data)
        with torch.no_grad():
            for name, tensor in facts.items():
                getattr(self.fixed, name).copy_(tensor)
        _look(self.fixed)

    def has_labels(self, data: str | os.PathLike[str]) -> bool:
        """Tells if the model computes with the array and the statistics of a data set.

        Parameters
        ----------
        data : path-like
            Folder of the data set.

        Returns
        -------
        bool
            Within the digits of half precision, in which weights may be stored.
        """
        own = {name: getattr(self.fixed, name).cpu().double() for name in ("array", "mean", "deviation", "is_by_link")}
        return all(torch.allclose(own[name], of, rtol=2e-3, atol=1e-3 * float(of.abs().max())) for name, of in _facts(data).items())

    def power(self, x: Tensor) -> Tensor:
        """Predicts from where the power arrives.

        Parameters
        ----------
        x : Tensor, shape (batch, ways, 16)
            Ways of the links, as of `map2aps.PolarView.ways`.

        Returns
        -------
        Tensor, shape (batch, 720)
            Share of the power by direction: the sum over all is 1.

        Raises
        ------
        ValueError
            For ways of another shape.
        """
        if x.dim() != 3 or x.shape[2] != POLAR_FEATURES + 2:
            raise ValueError(f"expected ways of shape (batch, ways, {POLAR_FEATURES + 2}), got {tuple(x.shape)}")
        strength = torch.exp(torch.clamp(6 * self.ways(x), max=60)) * (x[..., 0] + 0.01) * x[..., 1]
        # Ways of zeros add nothing to the first direction.
        by_direction = strength.new_zeros(len(x), POLAR_DIRECTIONS).scatter_add(1, x[..., POLAR_FEATURES].long(), strength)
        return torch.softmax(torch.log(by_direction + 1e-6), 1)

    def forward(self, x: Tensor) -> Tensor:
        """Predicts spectra.

        Parameters
        ----------
        x : Tensor, shape (batch, ways, 16)
            Ways of the links, as of `map2aps.PolarView.ways`.

        Returns
        -------
        Tensor, shape (batch, 180)
            Spectra in the domain that ``fixed`` normalises to.

        Raises
        ------
        ValueError
            For ways of another shape.
        """
        out: Tensor = self.fixed(self.power(x))
        return out


def vit_reg(preset: Preset) -> VitReg:
    """The transformer of a preset."""
    return VitReg(224, 16, 768, 12, 12, 512) if preset == "paper" else VitReg(64, 8, 192, 6, 3, 192)


def width_of(preset: Preset) -> int:
    """Channels of the first stage of a preset."""
    return 64 if preset == "paper" else 32


MODELS: dict[str, Callable[[Preset], nn.Module]] = {
    "ms_areg": lambda preset: MsAreg(width_of(preset)),
    "ms_mlp": lambda preset: MsMlp(width_of(preset)),
    "adv_mlp": lambda preset: AdvMlp(width_of(preset)),
    "resnet_mlp": lambda preset: ResnetMlp(width_of(preset)),
    "radiounet": lambda preset: RadioUnet(64 if preset == "paper" else 16),
    "vit_reg": vit_reg,
    "resnet_conv1d": lambda preset: ResnetConv1d(width_of(preset)),
    # One size for all.
    "polar_reg": lambda preset: PolarReg(),
}


def build(name: str, preset: Preset = "paper", data: str | os.PathLike[str] | None = None) -> nn.Module:
    """Makes a model with random weights.

    Parameters
    ----------
    name : str
        One of `MODELS`: "ms_areg", "ms_mlp", "adv_mlp", "resnet_mlp", "radiounet", "vit_reg", "resnet_conv1d", "polar_reg".
    preset : {"paper", "small"}
        Sizes of the paper, or those for CPUs.
    data : path-like, optional
        Folder of the data set that the model is to learn: ``settings`` tell it, and Polar-Reg computes with its array and statistics
        (`PolarReg.set_labels`), without which it predicts nothing.

    Returns
    -------
    torch.nn.Module
        In training mode. Its ``settings`` are None without `data`.

    Raises
    ------
    ValueError
        For a name or preset that there is not.
    """
    if name not in MODELS:
        raise ValueError(f"name: '{name}' is none of {', '.join(MODELS)}")
    if preset not in ("paper", "small"):
        raise ValueError(f"preset: '{preset}' is neither 'paper' nor 'small'")
    model = MODELS[name](preset)
    # As the files of weights tell it.
    kind, settings = f"{name} {preset}", None
    if data is not None:
        from map2aps.torch import _settings

        settings = _settings.facts_of(kind, data)
        if isinstance(model, PolarReg):
            model.set_labels(data)
    model.kind, model.settings = kind, settings  # type: ignore[assignment]
    return model


def _told(kind: str | None) -> tuple[str, Preset] | None:
    """Model and preset of a file's metadata; None of a file that tells none, or one of another program."""
    name, _, preset = (kind or "").partition(" ")
    if name not in MODELS or preset not in ("paper", "small"):
        return None
    return name, "paper" if preset == "paper" else "small"


def load(file: str | os.PathLike[str], name: str | None = None, preset: Preset | None = None) -> nn.Module:
    """Makes a model with the weights of a file, set to evaluation.

    Parameters
    ----------
    file : path-like
        Safetensors, as ``cargo xtask train`` and `save` write.
    name, preset : optional
        Name and preset, see `build`; those in the file by default. If the file has none, the name is required and the preset is
        "paper" by default.

    Returns
    -------
    torch.nn.Module
        Its ``settings`` are those of the training (a dict), as ``config.json`` beside the file has them; None without one. Predictions are
        normalised with its ``settings["training_statistics"]``, not with those of the data that it is asked about: power relative to the
        link's maximum is ``y * std + mean``, for labels of ``settings["protocol"]`` "paper".

    Raises
    ------
    ValueError
        For a name or preset other than the file's own, a file without a name where none is given, and a ``config.json`` of another model.
    """
    from safetensors import safe_open

    from map2aps.torch import _settings

    with safe_open(os.fspath(file), "pt") as weights:
        kind = (weights.metadata() or {}).get("model")
        told = _told(kind)
        if told is None:
            if name is None:
                raise ValueError(f"{os.fspath(file)}: it does not tell its model, but {kind!r}; name it")
            told = name, preset or "paper"
        wanted = name or told[0], preset or told[1]
        if wanted != told:
            raise ValueError(f"{os.fspath(file)}: it holds {' '.join(told)}, not {' '.join(wanted)}")
        settings: Any = _settings.beside(file, " ".join(wanted))
        model = build(*wanted)
        model.load_state_dict({tensor: weights.get_tensor(tensor) for tensor in weights.keys()})
    model.settings = settings
    return model.eval()


def shipped(name: str = "polar_reg") -> nn.Module:
    """Makes a model with the weights that come with the package, set to evaluation; they are stored in half precision.

    Parameters
    ----------
    name : str
        Model of which weights are shipped, "ms_areg" or "polar_reg": both learnt labels of the protocol "paper", Polar-Reg
        converged ones, the default, MS-AReg those of R2 D1.

    Returns
    -------
    torch.nn.Module
        With ``settings``, as `load` gives them.
    """
    from safetensors.torch import load as tensors_of

    from map2aps import _native

    weights, settings = _native.shipped(name)
    model = build(name, "small")
    model.load_state_dict(tensors_of(weights))
    model.settings = json.loads(settings)
    return model.eval()


def check(model: nn.Module, data: str | os.PathLike[str]) -> None:
    """Makes sure that a model predicts labels as those of a data set are made.

    Angles of the protocol "released" are half a turn from those of "paper", and another array sees other spectra: predictions look
    as good, and are wrong. Of other limits, another material, carrier or sampling rate it warns: predictions are of paths that the
    labels lack, or lack some of theirs.

    Parameters
    ----------
    model : torch.nn.Module
        With ``settings``: of `load` or `shipped`, or one of your own that `build` or `save` was given the data set of.
    data : path-like
        Folder of the data set.

    Raises
    ------
    ValueError
        For labels of another protocol or array, a model without ``settings``, and one of images about the receiver.

    Warns
    -----
    UserWarning
        For labels of other limits, material, carrier or sampling rate.
    """
    from map2aps import Dataset, _native

    settings = getattr(model, "settings", None)
    if settings is None:
        raise ValueError(
            "model: it has no settings that tell which labels it learnt; build(..., data=...) and save(..., data=...) give it those of a data set"
        )
    learnt, found = (json.dumps(of) for of in (settings["data_configuration"], Dataset(data).manifest["configuration"]))
    if settings.get("frame", "map") != "map":
        raise ValueError("model: it takes images about the receiver, and ApsDataset draws those of the map")
    differences = _native.label_differences(settings["protocol"], learnt, found)
    for is_of_meaning, difference in differences:
        if is_of_meaning:
            raise ValueError(f"{os.fspath(data)}: the model learnt labels of another meaning: {difference}")
    if differences:
        told = "; ".join(difference for _, difference in differences)
        warnings.warn(f"{os.fspath(data)}: the model learnt other labels: {told}", stacklevel=2)


def save(
    model: nn.Module,
    file: str | os.PathLike[str],
    data: str | os.PathLike[str] | None = None,
    image_size: int | None = None,
) -> None:
    """Writes the weights of a model so that ``cargo xtask predict`` and ``train --warm-start`` read them.

    Beside them it writes what they do not tell, ``config.json``: size of the images, protocol, array and statistics of the labels. Without
    `data` these are the model's ``settings``, of `load`, `shipped`, `build` or `PolarReg.set_labels`; they become its ``settings``.

    Parameters
    ----------
    model : torch.nn.Module
        Of `build`, `load` or `shipped`, also behind ``DataParallel`` or ``torch.compile``.
    file : path-like
        Safetensors file; one that is there is replaced, and its folder is made.
    data : path-like, optional
        Folder of the data set that the model learnt.
    image_size : int, optional
        Rows and columns of the images that it learnt; as its ``settings`` have it by default.

    Raises
    ------
    ValueError
        For a model of another kind; an image size that is not known, or of a model that takes no images; and, before anything is written,
        where a ``config.json`` of another model is there, or one of other weights in the folder.

    Warns
    -----
    UserWarning
        For a model without ``settings``: only its weights are written.
    """
    from safetensors.torch import save_file

    from map2aps.torch import _settings

    # The model behind what spreads it over devices, or compiles it.
    while not isinstance(getattr(model, "kind", None), str) or hasattr(model, "_orig_mod"):
        inner = getattr(model, "module", None) or getattr(model, "_orig_mod", None)
        if not isinstance(inner, nn.Module):
            raise ValueError(f"model: expected one that build, load or shipped made, got {type(model).__name__}")
        model = inner
    kind = str(model.kind)
    known: Any = getattr(model, "settings", None)
    settings: Any = _settings.to_write(kind, known, data, image_size, not isinstance(model, PolarReg))
    if data is not None and isinstance(model, PolarReg) and not model.has_labels(data):
        raise ValueError(f"data: the model computes with another array or other statistics than those of {os.fspath(data)}; set_labels(data) sets them")
    _settings.check_place(file, kind, settings)
    tensors = {name: tensor.detach().cpu().contiguous() for name, tensor in model.state_dict().items()}
    Path(file).parent.mkdir(parents=True, exist_ok=True)
    if settings is None:
        save_file(tensors, os.fspath(file), {"model": kind})
        told = "nothing beside it tells what the model learnt: give data= and image_size=, for load, check and `cargo xtask predict`"
        warnings.warn(f"{os.fspath(file)}: {told}", stacklevel=2)
        return
    with _settings.written(file, settings):
        save_file(tensors, os.fspath(file), {"model": kind})
    model.settings = settings
