import importlib.util
import json
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import torch
from safetensors import SafetensorError
from safetensors.numpy import load_file
from safetensors.torch import save_file
from torch.utils.data import DataLoader

import map2aps
from map2aps.torch import ApsDataset, models

GOLDEN = Path(__file__).parents[2] / "golden"
SHIPPED = Path(__file__).parents[2] / "data" / "shipped"


def test_an_example_is_a_condition_and_the_target_that_predictions_are_scored_against(data: Path) -> None:
    examples = ApsDataset(data, "train", size=64, mirror=False)
    dataset = map2aps.Dataset(data)
    assert len(examples) == 12 * len(dataset.split("train"))
    condition, target = examples[5]
    assert (condition.dtype, condition.shape) == (torch.float32, (3, 64, 64))
    assert (target.dtype, target.shape) == (torch.float32, (180,))
    map_id, row, tx, rx = examples.links[5]
    one = dataset[map_id]
    assert (one["link_tx"][row], one["link_rx"][row]) == (tx, rx)
    # The spots are at the ends, the buildings those of the map.
    for plane, end in ((1, one["tx"][tx]), (2, one["rx"][rx])):
        y, x = np.unravel_index(int(condition[plane].argmax()), (64, 64))
        assert np.abs(np.array([x, y]) * 4 + 1.5 - end).max() <= 2.5
    buildings = one["buildings"].reshape(64, 4, 64, 4).mean((1, 3))
    assert np.allclose(condition[0], buildings, atol=1e-6)
    relative = 10 ** (one["aps_db"][row].astype(np.float64) / 10)
    linear = ApsDataset(data, "train", mirror=False, domain="linear")[5][1]
    assert np.allclose(linear, relative / relative.max(), atol=1e-6)


def test_targets_of_all_training_links_are_normalised(data: Path) -> None:
    examples = ApsDataset(data, "train", mirror=False)
    _, targets = examples.batch(np.arange(len(examples)))
    assert torch.isfinite(targets).all()
    again = torch.stack([examples[i][1] for i in range(len(examples))])
    assert torch.equal(again, targets)
    conditions, nothing = examples.batch([])
    assert conditions.shape == (0, 3, 64, 64) and nothing.shape == (0, 180)
    for numbers in (np.arange(6)[::2], torch.arange(0, 6, 2), np.array([0, 2, 4], np.uint8)):
        assert torch.equal(examples.batch(numbers)[1], targets[:6:2])


def test_mirror_images_stand_behind_their_example_in_the_training_part_alone(data: Path) -> None:
    plain, mirrored = (ApsDataset(data, "train", size=32, mirror=mirror) for mirror in (False, True))
    assert len(mirrored) == 4 * len(plain)
    condition, target = plain[3]
    images, targets = mirrored.batch([12, 13, 14, 15])
    for image, axes in zip(images, [(), (2,), (1,), (1, 2)]):
        assert torch.equal(image, condition.flip(axes))
    assert torch.equal(targets[1], target) and torch.equal(targets[2], target.flip(0))
    for part in ("develop", "test"):
        assert len(ApsDataset(data, part)) == len(ApsDataset(data, part, mirror=False))


@pytest.mark.filterwarnings("ignore:.*pin_memory:UserWarning", "ignore:This process:DeprecationWarning")
@pytest.mark.parametrize(("workers", "context"), [(0, None), (2, "fork"), (2, "forkserver"), (2, "spawn")])
def test_loaders_give_the_same_batches_with_any_workers(data: Path, workers: int, context: str | None) -> None:
    examples = ApsDataset(data, "train")
    loader = DataLoader(
        examples, batch_size=32, num_workers=workers, multiprocessing_context=context, pin_memory=True
    )
    batches = list(loader)
    for tensor in batches[0]:
        assert tensor.is_pinned() == torch.cuda.is_available()
    conditions, targets = (torch.cat(part) for part in zip(*batches))
    expected = examples.batch(np.arange(len(examples)))
    assert torch.equal(conditions, expected[0]) and torch.equal(targets, expected[1])


@pytest.mark.parametrize("domain", ["normalised", "linear"])
def test_a_part_without_links_has_no_examples(tmp_path: Path, domain: str) -> None:
    dataset = map2aps.make_dataset(tmp_path / "set", 1, tx_per_map=1, rx_per_map=3, progress=None)
    empty = [part for part in ("train", "develop", "test") if not dataset.split(part)]
    assert len(empty) == 2
    for part in empty:
        examples = ApsDataset(dataset.path, part, size=16, domain=domain)
        conditions, targets = examples.batch([])
        assert (len(examples), examples.links.shape) == (0, (0, 4))
        assert conditions.shape == (0, 3, 16, 16) and targets.shape == (0, 180)
        assert list(DataLoader(examples, batch_size=4)) == []
        with pytest.raises(IndexError, match="0 is not from 0 to below 0"):
            examples[0]


def test_threads_share_examples(data: Path) -> None:
    examples = ApsDataset(data, "train")
    expected = examples.batch(np.arange(20))
    with ThreadPoolExecutor(4) as threads:
        for conditions, targets in threads.map(lambda _: examples.batch(np.arange(20)), range(8)):
            assert torch.equal(conditions, expected[0]) and torch.equal(targets, expected[1])


def test_examples_are_pickled_by_their_place(data: Path) -> None:
    examples = ApsDataset(data, "test", size=16)
    again = pickle.loads(pickle.dumps(examples))
    assert torch.equal(again[2][0], examples[2][0])


def test_bad_settings_and_numbers_are_named(data: Path, tmp_path: Path) -> None:
    for call, error, told in [
        (lambda: ApsDataset(data, "training"), ValueError, "'training'"),
        (lambda: ApsDataset(data, "train", size=0), ValueError, "size: 0"),
        (lambda: ApsDataset(data, "train", domain="db"), ValueError, "'db'"),
        (lambda: ApsDataset(data, "train", condition="map"), ValueError, "'map'"),
        (lambda: ApsDataset(data, "train", size=-1), ValueError, "size: .*int -1"),
        (lambda: ApsDataset(data, "train", condition="polar", maps=1.5), ValueError, "maps.*float 1.5"),
        (lambda: ApsDataset(data, "test").batch([0.5]), ValueError, "indices: expected integers .*float64"),
        (lambda: ApsDataset(tmp_path, "train"), ValueError, "not a data set"),
        (lambda: ApsDataset(tmp_path / "none", "train"), FileNotFoundError, "none"),
        (lambda: ApsDataset(data, None), ValueError, "split: expected a string, got NoneType"),
        (lambda: ApsDataset(data, "train", mirror="no"), ValueError, "mirror: expected True or False, got str 'no'"),
        (lambda: ApsDataset(data, "train", maps=data), ValueError, "only condition='polar' takes maps"),
        (lambda: ApsDataset(data, "test").batch(np.array([2**64 - 1], np.uint64)), IndexError, str(2**64 - 1)),
        (lambda: ApsDataset(data, "test")[10_000], IndexError, "10000"),
        (lambda: ApsDataset(data, "test")[-1], IndexError, "-1"),
        (lambda: ApsDataset(data, "test").batch([[1, 2]]), ValueError, r"shape \(1, 2\)"),
    ]:
        with pytest.raises(error, match=told):
            call()
    circular = map2aps.make_dataset(
        tmp_path / "set", 1, tx_per_map=1, rx_per_map=3, array=map2aps.UniformCircular(8, 0.5), progress=None
    )
    with pytest.raises(ValueError, match="uniform_circular"):
        ApsDataset(circular.path, "train")


@pytest.fixture(scope="module")
def golden() -> ModuleType:
    """The script that made the golden values: its weights and images."""
    spec = importlib.util.spec_from_file_location("golden_models", GOLDEN / "models.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", [name for name in models.MODELS if name != "polar_reg"])
def test_models_are_those_that_the_rust_ones_are_held_to(name: str, golden: ModuleType) -> None:
    stored = load_file(GOLDEN / "models" / f"{name}.safetensors")
    model = golden.set_weights(models.build(name)).eval()
    with torch.no_grad():
        found = model(golden.images(64)).numpy()
    assert np.allclose(found, stored["eval_64"], rtol=1e-9, atol=1e-9)


def test_the_regularizer_is_the_one_that_the_rust_one_is_held_to(golden: ModuleType) -> None:
    stored = load_file(GOLDEN / "models" / "ms_areg.safetensors")
    critic = golden.set_weights(models.Regularizer(64)).eval()
    with torch.no_grad():
        logits = critic(golden.images(64), golden.targets())
    assert logits.shape == (2, 1) and np.allclose(logits.numpy(), stored["critic_eval_64"], rtol=1e-9, atol=1e-9)


def test_polar_reg_is_the_one_that_the_rust_one_is_held_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(GOLDEN))
    script, stored = importlib.import_module("polar_reg"), load_file(GOLDEN / "models" / "polar_reg.safetensors")
    model, ways = script.model(), script.inputs()
    with torch.no_grad():
        for name, found in (("power", model.power(ways)), ("eval", model(ways))):
            assert np.allclose(found.numpy(), stored[name], rtol=1e-9, atol=1e-9), name


def test_polar_reg_takes_the_geometry_of_a_data_set(data: Path, tmp_path: Path) -> None:
    dataset = map2aps.Dataset(data)
    part = next(part for part in ("train", "develop", "test") if 0 in dataset.split(part))
    examples = ApsDataset(data, part, mirror=False, condition="polar")
    of_map = np.flatnonzero(examples.links[:, 0] == 0)
    conditions, targets = examples.batch(of_map)
    # The first synthetic map of a seed is that of a scene.
    view, one = map2aps.PolarView(map2aps.Scene.synthetic(dataset.manifest["seed"])), dataset[0]
    for condition, (_, _, tx, rx) in zip(conditions, examples.links[of_map]):
        ways = view.ways(one["tx"][tx], one["rx"][rx])[0]
        assert np.array_equal(condition[: len(ways)], ways) and not condition[len(ways) :].any()
    assert torch.equal(targets, ApsDataset(data, part, mirror=False).batch(of_map)[1])
    model = models.build("polar_reg").eval()
    model.fixed.array.fill_(0.5)
    with torch.no_grad():
        assert torch.isfinite(model(conditions)).all() and model(conditions).shape == targets.shape
    mirrored = ApsDataset(data, "train", condition="polar")
    assert mirrored[5][0].shape[1:] == (16,) and (mirrored[5][0][:, 1] == 1).all()
    loader = DataLoader(mirrored, batch_size=4)
    assert all(batch.shape == (len(batch), batch.shape[1], 16) for batch, _ in loader)
    again = pickle.loads(pickle.dumps(examples))
    assert torch.equal(again[1][0], examples[1][0])
    for maps, error, told in [(tmp_path, OSError, "0.json"), (tmp_path / "none", OSError, "none")]:
        with pytest.raises(error, match=told):
            ApsDataset(data, part, condition="polar", maps=maps)


def test_small_models_have_the_numbers_of_parameters_that_the_rust_ones_have() -> None:
    expected = {
        "ms_areg": 3_789_652,
        "adv_mlp": 3_444_564,
        "ms_mlp": 3_715_796,
        "resnet_mlp": 2_910_932,
        "resnet_conv1d": 4_721_921,
        "radiounet": 1_969_428,
        "vit_reg": 2_791_092,
        "polar_reg": 3_841,
    }
    found = {name: sum(p.numel() for p in models.build(name, "small").parameters()) for name in models.MODELS}
    assert found == expected
    assert sum(p.numel() for p in models.Regularizer(32).parameters()) == 3_009_697


@pytest.mark.filterwarnings("ignore:.*nothing beside it tells:UserWarning")
def test_weights_go_through_a_file_that_tells_its_model(tmp_path: Path) -> None:
    model = models.build("resnet_mlp", "small")
    models.save(model, tmp_path / "weights.safetensors")
    again = models.load(tmp_path / "weights.safetensors")
    assert not again.training
    for name, tensor in model.state_dict().items():
        assert torch.equal(again.state_dict()[name], tensor), name
    for wrapped in (torch.nn.DataParallel(model), torch.compile(model)):
        models.save(wrapped, tmp_path / "wrapped.safetensors")
        assert (tmp_path / "wrapped.safetensors").read_bytes() == (tmp_path / "weights.safetensors").read_bytes()
    with pytest.raises(ValueError, match="model: .*got Linear"):
        models.save(torch.nn.Linear(2, 2), tmp_path / "wrapped.safetensors")
    for name, preset in [("resnet_mlp", "paper"), (None, "paper"), ("ms_mlp", "small"), ("ms_mlp", None)]:
        told = f"holds resnet_mlp small, not {name or 'resnet_mlp'} {preset or 'small'}"
        with pytest.raises(ValueError, match=told):
            models.load(tmp_path / "weights.safetensors", name, preset)
    for name, preset in [("resnet_mlp", None), (None, "small"), ("resnet_mlp", "small")]:
        assert models.load(tmp_path / "weights.safetensors", name, preset).kind == "resnet_mlp small"
    # Of another program, which says something else or nothing.
    tensors = {name: tensor.contiguous() for name, tensor in model.state_dict().items()}
    for metadata in ({"model": "resnet18 imagenet"}, None):
        save_file(tensors, tmp_path / "foreign.safetensors", metadata)
        assert models.load(tmp_path / "foreign.safetensors", "resnet_mlp", "small").kind == "resnet_mlp small"
        with pytest.raises(ValueError, match="does not tell its model"):
            models.load(tmp_path / "foreign.safetensors")
        with pytest.raises(RuntimeError, match="size mismatch"):
            models.load(tmp_path / "foreign.safetensors", "resnet_mlp")
    for bad in (("resnet", "paper"), ("ms_mlp", "tiny")):
        with pytest.raises(ValueError, match=bad[0] if bad[1] == "paper" else bad[1]):
            models.build(*bad)


def test_a_model_learns_from_a_loader(data: Path) -> None:
    loader = DataLoader(ApsDataset(data, "train", size=32), batch_size=48, shuffle=True, generator=torch.Generator().manual_seed(1))
    torch.manual_seed(1)
    model = models.build("resnet_mlp", "small").train()
    optimizer = torch.optim.AdamW(model.parameters(), lr=1e-3)
    losses = []
    for _ in range(4):
        for condition, target in loader:
            loss = torch.nn.functional.mse_loss(model(condition), target)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            losses.append(loss.item())
    assert np.mean(losses[-3:]) < 0.8 * np.mean(losses[:3])


def test_polar_reg_is_told_the_array_of_a_data_set(tmp_path: Path) -> None:
    few: dict[str, Any] = {"tx_per_map": 1, "rx_per_map": 4, "progress": None}
    paper, released, eight = (
        map2aps.make_dataset(tmp_path / name, 5, protocol=protocol, array=array, **few).path
        for name, protocol, array in (("a", "paper", None), ("b", "released", None), ("c", "paper", map2aps.UniformLinear(8)))
    )
    conditions, targets = ApsDataset(paper, "train", condition="polar").batch(range(8))
    silent = models.build("polar_reg")
    for model in (silent, pickle.loads(pickle.dumps(silent))):
        with pytest.raises(ValueError, match=r"build\('polar_reg', data=...\) or set_labels"):
            model(conditions)
    assert silent.settings is None and not silent.has_labels(paper)
    # The matrix is that of weights that learnt labels of the same array.
    model = models.build("polar_reg", data=paper)
    assert torch.allclose(model.fixed.array, models.shipped("polar_reg").fixed.array, atol=2e-3 * float(model.fixed.array.max()))
    told = model.settings["training_statistics"]
    assert torch.allclose(torch.stack([model.fixed.mean, model.fixed.deviation]), torch.tensor([told["mean"], told["std"]]))
    assert model.fixed.is_by_link == 0 and model.has_labels(paper) and not model.has_labels(released) and not model.has_labels(eight)
    optimizer = torch.optim.AdamW(model.parameters(), lr=3e-3)
    losses = []
    for _ in range(40):
        optimizer.zero_grad()
        loss = (model(conditions) - targets).square().mean()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
    assert losses[-1] < 0.9 * losses[0]
    # Of another data set the settings are not written beside it.
    file = tmp_path / "run" / "weights.safetensors"
    with pytest.raises(ValueError, match=r"data: .*set_labels\(data\)"):
        models.save(model, file, data=eight)
    with pytest.raises(ValueError, match="image_size: polar_reg takes no images"):
        models.save(model, file, image_size=32)
    assert not file.parent.exists()
    models.save(model, file)
    again = models.load(file)
    assert torch.equal(again(conditions), model.eval()(conditions)) and again.has_labels(paper)
    models.check(again, paper)
    again.set_labels(released)
    assert again.has_labels(released) and again.fixed.is_by_link == 1
    models.check(again, released)
    # Without `data` the settings are those of the labels that it was told last.
    models.save(again, tmp_path / "other" / "weights.safetensors")
    other = models.load(tmp_path / "other" / "weights.safetensors")
    models.check(other, released)
    assert other.has_labels(released) and other.settings["protocol"] == "released"
    with pytest.raises(ValueError, match="the model learnt labels of another meaning"):
        models.check(other, paper)
    # Its class alone tells no preset, and so has no settings.
    bare = models.PolarReg()
    bare.set_labels(paper)
    assert bare.has_labels(paper)


def test_what_weights_do_not_tell_is_kept_beside_them(data: Path, tmp_path: Path) -> None:
    file = tmp_path / "run" / "weights.safetensors"
    model = models.build("resnet_mlp", "small")
    assert model.settings is None
    for given, told in [
        ({"data": data}, "image_size: nothing tells it.*ApsDataset"),
        ({"image_size": 32}, "image_size: .*give data= too"),
        ({"data": data, "image_size": 0}, "image_size: expected a number of pixels, got int 0"),
        ({"data": data, "image_size": 32.0}, "image_size: .*float 32.0"),
    ]:
        with pytest.raises(ValueError, match=told):
            models.save(model, file, **given)
    assert not file.parent.exists()
    models.save(model, file, data=data, image_size=32)
    settings = json.loads((file.parent / "config.json").read_text(encoding="utf-8"))
    assert model.settings == settings == models.load(file).settings
    found = (settings["model"], settings["preset"], settings["image_size"], settings["protocol"])
    assert found == ("resnet_mlp", "small", 32, "released")
    assert settings["data_configuration"] == map2aps.Dataset(data).manifest["configuration"]
    targets = ApsDataset(data, "train", mirror=False, domain="linear")
    power = targets.batch(range(len(targets)))[1].double()
    statistics = settings["training_statistics"]
    assert abs(statistics["mean"] - float(power.mean())) < 1e-4 and abs(statistics["std"] - float(power.std())) < 1e-4
    models.check(models.load(file), data)
    # A tuned model keeps what is known of it, also in parallel; a data set beside it is another training.
    tuned = models.load(file)
    models.save(torch.nn.DataParallel(tuned), tmp_path / "tuned" / "weights.safetensors")
    assert models.load(tmp_path / "tuned" / "weights.safetensors").settings == settings
    models.save(tuned, tmp_path / "tuned" / "weights.safetensors", image_size=48)
    assert models.load(tmp_path / "tuned" / "weights.safetensors").settings == settings | {"image_size": 48}
    built = models.build("ms_mlp", "small", data=data)
    models.check(built, data)
    models.save(built, tmp_path / "built.safetensors", image_size=16)
    assert models.load(tmp_path / "built.safetensors").settings["image_size"] == 16


def test_settings_of_other_weights_are_neither_taken_nor_replaced(data: Path, tmp_path: Path) -> None:
    file, config = tmp_path / "weights.safetensors", tmp_path / "config.json"
    model, other = models.build("resnet_mlp", "small"), models.build("ms_mlp", "small")
    models.save(model, file, data=data, image_size=32)
    kept = config.read_bytes()
    for given in ({}, {"data": data, "image_size": 32}):
        with pytest.raises(ValueError, match="config.json: it is of a training of resnet_mlp, preset small, .* are of ms_mlp, preset small"):
            models.save(other, tmp_path / "other.safetensors", **given)
    with pytest.raises(ValueError, match="taken for the settings of these weights; give data="):
        models.save(models.build("resnet_mlp", "small"), tmp_path / "other.safetensors")
    # Its own are replaced, those of others beside it are not.
    models.save(model, file, image_size=48)
    models.save(model, tmp_path / "second.safetensors")
    with pytest.raises(ValueError, match="another training, whose weights second.safetensors lie there too"):
        models.save(model, file, image_size=32)
    assert json.loads(config.read_text(encoding="utf-8"))["image_size"] == 48 and kept != config.read_bytes()
    config.write_text(config.read_text(encoding="utf-8").replace("resnet_mlp", "radiounet"), encoding="utf-8")
    with pytest.raises(ValueError, match="config.json: it is of a training of radiounet, preset small, .* move one of them elsewhere"):
        models.load(file)
    for text, told in (("{}", "it lacks 'model'"), ("[1]", "no settings of a training"), ("{", "no settings of a training")):
        config.write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=f"config.json: .*{told}"):
            models.load(file)
    config.unlink()
    with pytest.warns(UserWarning, match="weights.safetensors: nothing beside it tells what the model learnt: give data= and image_size=") as told:
        models.save(models.build("resnet_mlp", "small"), file)
    assert told[0].filename == __file__ and not config.exists() and models.load(file).settings is None


def test_how_images_are_drawn_is_kept_where_labels_are_told_anew(data: Path, tmp_path: Path) -> None:
    file, config = tmp_path / "weights.safetensors", tmp_path / "config.json"
    models.save(models.build("resnet_mlp", "small"), file, data=data, image_size=32)
    drawn = {"frame": "receiver", "sigma_px": 3.5, "image_size": 48}
    settings = json.loads(config.read_text(encoding="utf-8")) | drawn
    config.write_text(json.dumps(settings), encoding="utf-8")
    model = models.load(file)
    models.save(model, tmp_path / "tuned" / "weights.safetensors", data=data)
    assert model.settings == models.load(tmp_path / "tuned" / "weights.safetensors").settings == settings
    models.save(model, tmp_path / "larger" / "weights.safetensors", data=data, image_size=64)
    assert model.settings == settings | {"image_size": 64}


def test_a_save_that_fails_keeps_what_was_there(data: Path, tmp_path: Path) -> None:
    file, config = tmp_path / "weights.safetensors", tmp_path / "config.json"
    model = models.build("resnet_mlp", "small")
    models.save(model, file, data=data, image_size=32)
    kept, settings = [file.read_bytes(), config.read_bytes()], model.settings
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.add_(1)
    # Settings that JSON does not hold.
    model.settings = settings | {"data": {1, 2}}
    with pytest.raises(TypeError, match="set"):
        models.save(model, file)
    assert [file.read_bytes(), config.read_bytes()] == kept
    # Neither weights nor settings can be written where a folder is.
    model.settings = settings
    for name in ("weights.safetensors", "config.json"):
        (tmp_path / name[0] / name).mkdir(parents=True)
        with pytest.raises((OSError, SafetensorError)):
            models.save(model, tmp_path / name[0] / file.name)
    assert [one.name for one in (tmp_path / "w").iterdir()] == [file.name]
    assert sorted(one.name for one in (tmp_path / "c").iterdir()) == [config.name, file.name]


class Named(ApsDataset):
    """Has something of its own, and another constructor."""

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, "test", size=16)
        self.name = folder.name


def test_a_subclass_stays_itself_in_worker_processes(data: Path) -> None:
    examples = Named(data)
    again = pickle.loads(pickle.dumps(examples))
    assert type(again) is Named and again.name == data.name
    assert torch.equal(again[3][0], examples[3][0])


def test_shipped_weights_load_in_one_line(data: Path, tmp_path: Path) -> None:
    model = models.shipped("polar_reg")
    assert not model.training
    assert model.settings["protocol"] == "paper" and model.settings["training_statistics"]["std"] > 0
    models.save(model, tmp_path / "weights.safetensors")
    again = models.load(tmp_path / "weights.safetensors").state_dict()
    for name, tensor in model.state_dict().items():
        assert torch.equal(tensor, again[name]), name
    # Open ground all around: no way arrives, and the answer is a spectrum all the same.
    spectrum = model(torch.zeros(1, 1, models.POLAR_FEATURES + 2))
    assert spectrum.shape == (1, 180) and torch.isfinite(spectrum).all()
    for shape in ((2, 180, 210), (30, models.POLAR_FEATURES + 2)):
        with pytest.raises(ValueError, match=r"shape \(batch, ways, 16\), got"):
            model(torch.zeros(shape))
    with pytest.raises(ValueError, match="protocol: paper in the training, released here"):
        models.check(model, data)
    with pytest.raises(ValueError, match=r"no settings .*save\(..., data=...\)"):
        models.check(models.build("polar_reg"), data)
    few: dict[str, Any] = {"tx_per_map": 1, "rx_per_map": 2, "protocol": "paper", "progress": None}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        models.check(model, map2aps.make_dataset(tmp_path / "paper", 1, store_pdp=True, **few).path)
    eight = map2aps.make_dataset(tmp_path / "eight", 1, array=map2aps.UniformLinear(8), **few)
    with pytest.raises(ValueError, match="array: .*16.* in the training, .*8.* here"):
        models.check(model, eight.path)
    other = map2aps.make_dataset(
        tmp_path / "other", 1, limits="r2d1", material="pec", frequency_hz=28e9, sampling_rate_hz=100e6, **few
    )
    with pytest.warns(UserWarning) as told:
        models.check(model, other.path)
    for setting in ("max_diffractions: 2 in the training, 1 here", "material: concrete", "frequency_hz", "sampling_rate_hz"):
        assert setting in str(told[0].message)
    with pytest.raises(ValueError, match="no weights of 'vit_reg' are shipped, only of ms_areg, polar_reg"):
        models.shipped("vit_reg")


@pytest.mark.parametrize("name", ["ms_areg", "polar_reg"])
def test_shipped_weights_reproduce_their_scores(name: str) -> None:
    stated = json.loads((SHIPPED.with_suffix(".json")).read_text(encoding="utf-8"))[name]
    model = models.shipped(name)
    models.check(model, SHIPPED)
    maps = {"condition": "polar", "maps": SHIPPED.parent / "helsinki.geojson"} if name == "polar_reg" else {}
    linear, examples = (ApsDataset(SHIPPED, "test", domain=domain, **maps) for domain in ("linear", "normalised"))
    conditions, truth = examples.batch(np.arange(len(examples)))
    with torch.no_grad():
        prediction = model(conditions).double()
    # From the statistics of the training to those of this data set, which its targets and their power give.
    own = model.settings["training_statistics"]
    power = linear.batch(np.arange(len(linear)))[1].double()
    std = float(power.std() / truth.double().std())
    mean = float(power.mean() - std * truth.double().mean())
    wanted = (prediction * own["std"] + own["mean"] - mean) / std
    found = map2aps.metrics(truth.double().numpy(), wanted.numpy(), "paper").summary
    for metric, value in stated.items():
        assert abs(found[metric] - value) <= 1e-3 * max(1.0, abs(value)), metric
