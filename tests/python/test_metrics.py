from pathlib import Path

import numpy as np
import pytest

import map2aps


@pytest.fixture
def spectra() -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(1)
    truth = generator.random((20, 180))
    return truth, truth + 0.1 * generator.standard_normal((20, 180))


def test_point_errors_are_those_of_numpy(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = spectra
    scores = map2aps.metrics(truth, prediction, "paper")
    error = truth - prediction
    assert np.allclose(scores["mae"], np.abs(error).mean(1), rtol=1e-12)
    assert np.allclose(scores["mse"], (error**2).mean(1), rtol=1e-12)
    cosine = (truth * prediction).sum(1) / np.linalg.norm(truth, axis=1) / np.linalg.norm(prediction, axis=1)
    assert np.allclose(scores["cosine"], cosine, rtol=1e-12)
    psnr = 20 * np.log10(np.ptp(truth)) - 10 * np.log10((error**2).mean(1))
    assert np.allclose(scores["psnr_db"], psnr, rtol=1e-12)
    assert np.isclose(scores.summary["mae"], scores["mae"].mean())
    assert scores.rows.tolist() == list(range(20)) and len(scores.rejected) == 0
    assert scores.report["overall"]["samples"] == 20


def test_scores_are_told_in_short_and_decibels_are_warned_of(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = spectra
    scores = map2aps.metrics(truth, prediction)
    assert repr(scores).startswith("Scores(20 samples, 0 rejected; means: mae 0.0")
    with pytest.warns(UserWarning, match="truth: no value is above 0: .* not of decibels"):
        map2aps.metrics(10 * np.log10(truth), 10 * np.log10(np.abs(prediction)))


def test_a_peak_one_bin_off_is_two_degrees_off() -> None:
    truth, prediction = np.zeros((1, 180)), np.zeros((1, 180))
    truth[0, 20] = prediction[0, 21] = 1.0
    paper, released = (map2aps.metrics(truth, prediction, name) for name in ("paper", "released"))
    # The released code counts bins as degrees.
    assert paper["ple_deg"].tolist() == [2.0] and released["ple_deg"].tolist() == [1.0]


def test_maps_and_the_range_are_told_apart(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = spectra
    scores = map2aps.metrics(truth, prediction, map_ids=np.arange(20) % 3, data_range=2.0)
    assert [of["map_id"] for of in scores.report["maps"]] == [0, 1, 2]
    assert scores.report["data_range"] == 2.0
    spread = np.repeat(np.arange(20) % 3, 2)[::2]
    for same in (spread, spread.astype(np.uint8), (np.arange(20) % 3).tolist()):
        assert map2aps.metrics(truth, prediction, map_ids=same, data_range=2.0).report == scores.report


def test_samples_with_nan_are_listed_and_in_no_mean(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = spectra
    prediction[4, 7] = np.nan
    truth[9, 0] = np.inf
    scores = map2aps.metrics(truth, prediction)
    assert scores.rejected.tolist() == [4, 9] and len(scores["mae"]) == 18
    assert scores.rows.tolist() == [row for row in range(20) if row not in (4, 9)]
    with pytest.raises(ValueError, match="none of 20 samples"):
        map2aps.metrics(truth, np.full_like(truth, np.nan))


def test_shapes_and_types_that_do_not_fit_are_named(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = spectra
    for call, told in [
        (lambda: map2aps.metrics(truth, prediction[:19]), r"\(20, 180\).*\(19, 180\)"),
        (lambda: map2aps.metrics(truth, prediction[:, :90]), r"\(20, 180\).*\(20, 90\)"),
        (lambda: map2aps.metrics(truth[0], prediction[0]), r"truth: .*float64 of shape \(180,\)"),
        (lambda: map2aps.metrics(truth.astype(complex), prediction), r"truth: .*complex128"),
        (lambda: map2aps.metrics(truth, prediction.astype(str)), r"prediction: .*<U"),
        (lambda: map2aps.metrics(truth, prediction, map_ids=[1, 2]), r"map_ids: .*shape \(2,\)"),
        (lambda: map2aps.metrics(truth, prediction, map_ids=np.full(20, -1)), "-1 is out of range"),
        (lambda: map2aps.metrics(truth, prediction, map_ids=np.zeros(20)), "integers"),
        (lambda: map2aps.metrics(truth, prediction, data_range=0.0), "data range"),
        (lambda: map2aps.metrics(truth, prediction, data_range=np.nan), "data range"),
        (lambda: map2aps.metrics(truth, prediction, data_range="1"), "data_range: .*str '1'"),
        (lambda: map2aps.metrics(truth, None), r"prediction: .*object of shape \(\)"),
        (lambda: map2aps.metrics(truth, prediction, "both"), "`both`"),
        (lambda: map2aps.metrics(np.zeros((0, 180)), np.zeros((0, 180))), "no sample"),
        (lambda: map2aps.metrics(np.zeros((3, 0)), np.zeros((3, 0))), "at least one bin"),
    ]:
        with pytest.raises(ValueError, match=told):
            call()


def test_views_and_precisions_give_the_same_scores(spectra: tuple[np.ndarray, np.ndarray]) -> None:
    truth, prediction = (values.astype(np.float32) for values in spectra)
    expected = map2aps.metrics(truth, prediction)["ple_deg"]
    wide = np.repeat(truth, 2, axis=1)[:, ::2]
    for t, p in [(truth.astype(np.float64), prediction), (wide, prediction), (np.asfortranarray(truth), prediction.astype(np.float64))]:
        assert np.array_equal(map2aps.metrics(t, p)["ple_deg"], expected)


def test_scores_are_a_dict_of_metrics() -> None:
    truth = np.random.default_rng(1).random((3, 180))
    scores = map2aps.metrics(truth, truth[::-1])
    assert "mae" in scores and "none" not in scores and len(scores) == len(list(scores))
    assert dict(scores).keys() == scores.values.keys()


def test_the_protocol_is_that_of_the_data_set_if_one_is_given(spectra: tuple[np.ndarray, np.ndarray], tmp_path: Path) -> None:
    few = {"tx_per_map": 1, "rx_per_map": 2, "progress": None}
    for protocol in ("paper", "released"):
        made = map2aps.make_dataset(tmp_path / protocol, 1, protocol=protocol, **few)
        assert made.protocol == protocol
        found, expected = (map2aps.metrics(*spectra, protocol=of) for of in (made, protocol))
        assert found.report == expected.report and np.array_equal(found["ple_deg"], expected["ple_deg"])
    made.manifest["configuration"].pop("label")
    assert made.protocol is None
    with pytest.raises(ValueError, match="protocol: .*released does not tell that of its labels; name it"):
        map2aps.metrics(*spectra, protocol=made)
