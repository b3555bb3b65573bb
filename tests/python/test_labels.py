import inspect

import numpy as np
import pytest

import map2aps


def one_path(delay_s: float = 310e-9, azimuth_rad: float = 0.4, gain: complex = 1e-4) -> map2aps.Paths:
    return map2aps.Paths.from_arrays([0, 1], [delay_s], [azimuth_rad], [gain])


def test_one_path_makes_a_peak_of_its_power_where_it_comes_from() -> None:
    label = map2aps.label(one_path(), "paper")
    assert label.aps_db.shape == (1, 180) and label.is_labelled.tolist() == [True]
    assert repr(label) == "Labels(1 links, 1 labelled, 180 angles)"
    peak = label.aps_db[0].argmax()
    # A linear array sees an angle and its mirror image alike.
    assert min(abs(label.angle_deg[peak] - angle) for angle in (np.rad2deg(0.4), 180 - np.rad2deg(0.4))) <= 2.0
    assert abs(label.aps_db[0].max() + 80.0) < 0.3


def test_the_label_is_the_formula_at_its_bins() -> None:
    paths = map2aps.Paths.from_arrays([0, 2], [310e-9, 455e-9], [0.4, -1.1], [1e-4, 3e-5j])
    label = map2aps.label(paths, "paper", map2aps.UniformLinear(8, 0.4), sampling_rate_hz=100e6)
    tau = np.linspace(250e-9, 520e-9, 20001)[:, None]
    theta = np.deg2rad(label.angle_deg)[None]
    q = np.zeros((len(tau), 180))
    for delay, azimuth, power in zip(paths.delay_s, paths.arrival_azimuth_rad, np.abs(paths.gain) ** 2):
        psi = np.pi * 0.4 * (np.sin(theta) - np.sin(azimuth))
        response = np.where(np.abs(psi) < 1e-12, 1.0, np.sin(8 * psi) / (8 * np.sin(psi) + 1e-300))
        q += power * np.sinc(100e6 * (tau - delay)) ** 2 * response**2
    assert np.abs(label.aps_db[0] - 10 * np.log10(q.max(0))).max() < 1e-3


def test_no_links_have_no_labels() -> None:
    nothing = map2aps.Paths.from_arrays([0], [], [], [])
    assert map2aps.label(nothing).aps_db.shape == (0, 180)
    assert map2aps.pdp(nothing).pdp_db.shape == (0, 401)
    with pytest.raises(ValueError, match="ascend"):
        map2aps.Paths.from_arrays([], [], [], [])


def test_columns_of_any_precision_and_layout_make_the_same_labels() -> None:
    delay, azimuth, gain = np.array([310e-9, 455e-9, 600e-9]), np.array([0.4, -1.1, 2.0]), np.array([1e-4, 3e-5j, 1e-5])
    delay, azimuth, gain = (np.float32(delay), np.float32(azimuth), np.complex64(gain))
    expected = map2aps.label(map2aps.Paths.from_arrays([0, 2, 3], delay, azimuth, gain)).aps_db
    for offset in (np.array([0, 2, 3], np.uint64), np.array([0, 9, 2, 9, 3], np.int32)[::2]):
        same = map2aps.Paths.from_arrays(offset, np.float64(delay).repeat(2)[::2], azimuth[::-1][::-1], gain.tolist())
        assert np.array_equal(map2aps.label(same).aps_db, expected)
    power = map2aps.label(map2aps.Paths.from_arrays([0, 2, 3], delay, azimuth, np.abs(gain))).aps_db
    assert np.allclose(power, expected, atol=1e-5)


def test_links_without_paths_have_no_label() -> None:
    paths = map2aps.Paths.from_arrays([0, 0, 1, 1], [310e-9], [0.4], [1e-4])
    label, profile = map2aps.label(paths), map2aps.pdp(paths)
    assert label.is_labelled.tolist() == [False, True, False]
    for values in (label.aps_db, profile.pdp_db):
        assert np.isnan(values).all(1).tolist() == [True, False, True]
        assert np.isfinite(values[1]).all()


def test_profiles_peak_at_the_delay() -> None:
    profile = map2aps.pdp(one_path(), "paper")
    assert profile.pdp_db.shape == (1, 401) and abs(profile.delay_s[profile.pdp_db[0].argmax()] - 310e-9) < 2.5e-9
    other = map2aps.pdp(one_path(), delay_points=11, last_delay_s=5e-7)
    assert np.allclose(other.delay_s, np.linspace(0.0, 5e-7, 11))


def test_a_profile_follows_its_array_and_rate() -> None:
    # Half a sample beside the delay sinc^2 is (2 / pi)^2, a quarter of one (2 sqrt(2) / pi)^2.
    for rate_hz, power in ((100e6, (2.0 / np.pi) ** 2), (50e6, 8.0 / np.pi**2)):
        profile = map2aps.pdp(one_path(300e-9, 0.0), "paper", sampling_rate_hz=rate_hz, delay_points=201, last_delay_s=1e-6)
        at = [profile.pdp_db[0, np.abs(profile.delay_s - delay).argmin()] for delay in (295e-9, 300e-9, 305e-9)]
        assert np.allclose(at, -80.0 + 10.0 * np.log10([power, 1.0, power]), atol=0.05)
    # One element hears two paths of one delay in every direction, many elements each in its own.
    both = map2aps.Paths.from_arrays([0, 2], [300e-9, 300e-9], [0.0, -np.pi / 2], [1e-4, 1e-4])
    for array, power in ((map2aps.UniformLinear(1, 0.5), 2.0), (map2aps.UniformLinear(64, 0.5), 1.0)):
        profile = map2aps.pdp(both, "paper", array, delay_points=201)
        assert abs(profile.pdp_db.max() - (-80.0 + 10.0 * np.log10(power))) < 0.05


def test_a_circular_array_sees_no_mirror_image() -> None:
    label = map2aps.label(one_path(), "paper", map2aps.UniformCircular(16, 1.0))
    mirror = np.abs(label.angle_deg - (180 - np.rad2deg(0.4))).argmin()
    assert label.aps_db[0, mirror] < label.aps_db[0].max() - 5.0


def test_settings_out_of_range_are_named() -> None:
    paths = one_path()
    for call, error, told in [
        (lambda: map2aps.label(paths, "papers"), ValueError, "`papers`"),
        (lambda: map2aps.label(paths, None), ValueError, "protocol: expected a string, got NoneType None"),
        (lambda: map2aps.label(paths, array=16), TypeError, "UniformLinear"),
        (lambda: map2aps.label(paths, array=map2aps.UniformLinear(0, 0.5)), ValueError, "elements"),
        (lambda: map2aps.label(paths, array=map2aps.UniformLinear(-1, 0.5)), ValueError, "elements: .*int -1"),
        (lambda: map2aps.label(paths, array=map2aps.UniformLinear(8, None)), ValueError, "spacing_wavelengths: .*None"),
        (lambda: map2aps.label(paths, sampling_rate_hz="a"), ValueError, "sampling_rate_hz: .*str 'a'"),
        (lambda: map2aps.label(paths, sampling_rate_hz=np.nan), ValueError, "sampling_rate_hz"),
        (lambda: map2aps.label([1.0]), TypeError, "expected Paths, got list"),
        (lambda: map2aps.pdp(None), TypeError, "expected Paths, got NoneType"),
        (lambda: map2aps.pdp(paths, delay_points=-5), ValueError, "delay_points: .*int -5"),
        (lambda: map2aps.pdp(paths, last_delay_s=np.inf), ValueError, "delay axis"),
        (lambda: map2aps.label(paths, array=map2aps.UniformCircular(4, -1.0)), ValueError, "radius_wavelengths"),
        (lambda: map2aps.label(paths, sampling_rate_hz=0.0), ValueError, "sampling_rate_hz"),
        (lambda: map2aps.pdp(paths, delay_points=1), ValueError, "delay axis of 1"),
    ]:
        with pytest.raises(error, match=told):
            call()


def test_columns_of_paths_that_do_not_fit_are_named() -> None:
    paths = one_path()
    for name, value, told in [
        ("delay_s", np.array([np.nan]), "delay_s"),
        ("delay_s", np.array([2.0]), "are the units seconds"),
        ("gain", np.array([np.nan]), "gain"),
        ("arrival_azimuth_rad", np.array([np.inf]), "azimuth"),
        ("delay_s", np.zeros(2), "departure_azimuth_rad: .*of shape \\(1,\\)"),
        ("gain", np.array(["a"]), "gain: expected complex numbers .*<U1"),
        ("path_offset", np.array([0.0, 1.0]), "path_offset: expected integers .*float64"),
        ("path_offset", np.array([0, 2]), "ascend from 0 to the length 1"),
        ("path_offset", np.array([1, 0, 1]), "ascend"),
        ("path_offset", np.array([], np.int64), "ascend"),
        ("interaction_offset", np.array([0, 1]), "ascend"),
        ("interaction_kind", np.array([300]), "interaction_kind: .*300 is out of range"),
        ("interaction_point_m", np.zeros((1, 2)), "interaction_point_m"),
        ("tx_m", np.zeros((2, 2)), r"tx_m: expected real numbers of shape \(1, 2\), .*shape \(2, 2\)"),
        ("rx_m", "nowhere", "rx_m: expected real numbers"),
    ]:
        with pytest.raises(ValueError, match=told):
            map2aps.label(paths.replace(**{name: value}))


def test_every_function_takes_the_same_protocol_by_default() -> None:
    # relabel keeps that of the data set.
    functions = [getattr(map2aps, name) for name in map2aps.__all__ if name != "relabel"]
    signatures = [inspect.signature(of) for of in functions if inspect.isfunction(of)]
    defaults = [of.parameters["protocol"].default for of in signatures if "protocol" in of.parameters]
    assert defaults == ["paper"] * 5
