//! Measures the loss by half precision in a data set through the crate that writes it.

use aps_data::released::ProfileFile;
use aps_data::{Axis, LinkStatus, Precision, Profile, ProfileLayout, ProfileRows};

/// A row as it is stored, perhaps with delays.
fn encode(
    db: &[f64],
    argmax: Option<&[f64]>,
    dtype: Precision,
) -> Result<Profile, aps_data::Error> {
    let axis = Axis {
        start: 0.0,
        stop: 1.0,
        count: db.len(),
        endpoint: true,
    };
    let layout = ProfileLayout {
        axis,
        dtype,
        argmax: argmax.is_some(),
    };
    Profile::encode(&ProfileRows { db, argmax }, &layout, &[LinkStatus::Valid])
}

/// A row after storing and reading, absolute \[dB\].
fn stored(row: &[f64], dtype: Precision) -> Vec<f64> {
    let profile = encode(row, None, dtype).unwrap();
    let mut relative = vec![0.0; row.len()];
    profile.read_relative_db(0, &mut relative);
    let peak = f64::from(profile.max_db()[0]);
    relative.iter().map(|&v| f64::from(v) + peak).collect()
}

/// A link of every depth down to -60,000 dB below a maximum that single precision cannot hold.
/// The stated errors (2^(k-11) dB at 2^k dB below the maximum) and the rounding of the maximum
/// itself are all that is lost; as powers relative to the maximum, which metrics act on, it is
/// 2e-4 at most.
#[test]
fn half_precision_loses_what_the_format_states() {
    let peak = -87.123_456_789;
    let row: Vec<f64> = (0..512_000)
        .map(|i| peak - f64::from(i) * 1e-3)
        .chain((1..=600).map(|i| peak - 100.0 * f64::from(i)))
        .collect();
    let mut worst_db = [0.0_f64; 17];
    let mut worst_power = 0.0_f64;
    for (before, after) in row.iter().zip(stored(&row, Precision::F16)) {
        let depth = peak - before;
        let k = depth.max(1.0).log2().floor();
        let error = (before - after).abs();
        worst_db[k as usize] = worst_db[k as usize].max(error);
        assert!(
            error <= (k - 11.0).exp2() + 4e-6,
            "{error} dB at -{depth} dB"
        );
        let power = |db: f64| 10_f64.powf(0.1 * (db - peak));
        worst_power = worst_power.max((power(*before) - power(after)).abs());
    }
    eprintln!("half precision: errors [dB] by power of two below the maximum {worst_db:.5?}");
    eprintln!("as power relative to the maximum: {worst_power:.1e}");
    assert!(worst_power < 2.3e-4);
    // The stated errors are attained, where every step of a range is sampled.
    for (k, worst) in worst_db[..9].iter().enumerate() {
        assert!(
            *worst > 0.9 * f64::powi(2.0, k as i32 - 11),
            "[2^{k}, ...) dB: {worst}"
        );
    }
    let worst = row
        .iter()
        .zip(stored(&row, Precision::F32))
        .map(|(a, b)| (a - b).abs() / (1.0 + peak - a))
        .fold(0.0, f64::max);
    eprintln!("single precision: {worst:.1e} dB for each dB below the maximum");
    assert!(worst < 4e-6);
}

/// A constant spectrum comes back constant, and its maximum as single precision has it; spectra
/// whose bins differ by less than half precision tells come back tied, never in another order.
#[test]
fn order_of_bins_survives_up_to_ties() {
    let constant = stored(&[-93.7; 180], Precision::F16);
    assert!(constant.iter().all(|v| *v == f64::from(-93.7_f32)));
    let row: Vec<f64> = (0..10_000)
        .map(|i| -80.0 - f64::from(i) * 1.7e-4 - 30.0)
        .collect();
    let back = stored(&row, Precision::F16);
    assert!(back.windows(2).all(|w| w[0] >= w[1]));
    assert!(back.windows(2).any(|w| w[0] == w[1]));
}

/// Delays: half precision steps are 1/2048 of the power of two below, 0.5 ns from 512 ns on and
/// 32 ns at the end of its range, 65,504 ns (20 km). Beyond that a row is refused by name; nothing
/// becomes infinite.
#[test]
fn delays_keep_eleven_bits_and_end_at_twenty_kilometres() {
    let mut worst = 0.0_f64;
    for i in 0..=65_504_u32 {
        let delay_ns = f64::from(i) * 0.999_9;
        let profile = encode(&[-80.0], Some(&[delay_ns]), Precision::F16).unwrap();
        let back = profile.argmax().unwrap()[0].to_f64();
        let step = delay_ns.max(6.2e-5).log2().floor().exp2() / 2048.0;
        worst = worst.max((back - delay_ns).abs() / step);
    }
    assert!(worst <= 1.0, "{worst} half steps");
    for beyond in [65_520.0, 1e9, 1e300] {
        let refused = encode(&[-80.0], Some(&[beyond]), Precision::F16);
        assert!(refused.unwrap_err().to_string().contains("out of range"));
    }
}

/// Ends of the range: a maximum of any power that single precision holds, values so far below that
/// half precision has no number for them (they become its least, 0 as a power), denormals, zeros.
#[test]
fn ends_of_the_range_are_finite() {
    for peak in [3e38, 1e4, 0.0, -1e-320, 1e-45, -300.0, -3e38] {
        let row = [peak, peak - 65_504.0, peak - 1e5, -1.7e308, peak - 1e-9];
        let profile = encode(&row, None, Precision::F16).unwrap();
        assert!(profile.max_db()[0].is_finite());
        let mut relative = [0.0; 5];
        profile.read_relative_db(0, &mut relative);
        assert!(
            relative.iter().all(|v| v.is_finite() && *v <= 0.0),
            "{peak}: {relative:?}"
        );
        assert_eq!((relative[0], relative[3]), (0.0, -65_504.0));
    }
    assert!(encode(&[1e39], None, Precision::F16).is_err());
}

/// Released files hold absolute dB: around -100 dB a step is 1/16 dB, around -300 dB 1/4 dB, many
/// times what the relative form loses.
#[test]
fn absolute_decibels_lose_more() {
    let row: Vec<f64> = (0..36_000).map(|i| -90.0 - f64::from(i) * 7.3e-3).collect();
    let zeros = vec![0.0; row.len()];
    let file = ProfileFile::rounded(&row, &zeros);
    let errors = row
        .iter()
        .zip(&file.bins)
        .map(|(db, bin)| (db - bin[0].to_f64()).abs());
    let absolute = errors.fold(0.0, f64::max);
    let relative = row
        .iter()
        .zip(stored(&row, Precision::F16))
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    eprintln!("absolute dB {absolute}, relative dB {relative}");
    assert!((0.1..=0.125).contains(&absolute) && relative <= absolute);
}
