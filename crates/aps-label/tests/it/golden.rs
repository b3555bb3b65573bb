//! Against values made by `tests/golden/label.py`: NumPy's straightforward formula, and single
//! elements of Q in 60 digits.

use crate::common::{MAXIMUM_ERROR, assert_power, assert_power_db, linear, tolerance, total_power};
use aps_label::{LabelConfig, Labeler, PathSample, Protocol};
use serde_json::Value;

const GOLDEN: &str = include_str!("../../../../tests/golden/label.json");

fn golden() -> Value {
    serde_json::from_str(GOLDEN).expect("label.json is JSON")
}

fn numbers(value: &Value) -> Vec<f64> {
    let array = value.as_array().expect("an array");
    array
        .iter()
        .map(|x| x.as_f64().expect("a number"))
        .collect()
}

fn paths(scene: &Value) -> Vec<PathSample> {
    let rows = scene["paths"].as_array().expect("an array");
    rows.iter()
        .map(|row| {
            let row = numbers(row);
            PathSample {
                delay_s: row[0],
                arrival_azimuth_rad: row[1],
                gain_db: row[2],
            }
        })
        .collect()
}

fn labeler(protocol: Protocol) -> Labeler {
    Labeler::new(&LabelConfig {
        pdp: true,
        ..LabelConfig::of(protocol)
    })
    .expect("valid preset")
}

#[test]
fn powers_agree_with_numpy() {
    for scene in golden()["scenes"].as_array().expect("scenes") {
        let paths = paths(scene);
        for protocol in [Protocol::Paper, Protocol::Released] {
            let what = format!("{protocol}, {}", scene["name"]);
            let want = &scene[protocol.to_string()];
            let label = labeler(protocol)
                .label(&paths)
                .expect("good paths")
                .expect("a label");
            let total = total_power(protocol, &paths);
            for (name, got) in [("aps_db", &label.aps_db), ("pdp_db", &label.pdp_db)] {
                let want = numbers(&want[name]);
                assert_eq!(got.len(), want.len(), "{what}: {name}");
                let relative = match (protocol, name) {
                    (Protocol::Paper, "aps_db") => MAXIMUM_ERROR,
                    _ => 0.0,
                };
                for (i, (got, want)) in got.iter().zip(want).enumerate() {
                    let (got, want) = (linear(*got), linear(want));
                    let allowed = relative * want + tolerance(want, total);
                    assert!(
                        (got - want).abs() <= allowed,
                        "{what}: {name}[{i}]: {got:e} instead of {want:e}"
                    );
                }
            }
        }
    }
}

/// The place of a maximum agrees too, or the two places are equal in power: which of two twins is
/// highest is a matter of rounding.
#[test]
fn places_of_the_sampled_maxima_agree_with_numpy() {
    let labeler = labeler(Protocol::Released);
    let (angles, delays) = (labeler.angles_deg(), labeler.delays_s());
    let mut equal = 0;
    let mut all = 0;
    for scene in golden()["scenes"].as_array().expect("scenes") {
        let paths = paths(scene);
        let total = total_power(Protocol::Released, &paths);
        let label = labeler.label(&paths).expect("good paths").expect("a label");
        let q = |tau, theta: f64| labeler.q(&paths, tau, theta.to_radians()).expect("finite");
        for (j, at) in numbers(&scene["released"]["aps_delay_index"])
            .into_iter()
            .enumerate()
        {
            let (got, want) = (label.aps_delay_s[j], delays[at as usize]);
            equal += usize::from(got == want);
            assert_power(
                q(got, angles[j]),
                q(want, angles[j]),
                total,
                &format!("{}: delay {j}", scene["name"]),
            );
        }
        for (i, at) in numbers(&scene["released"]["pdp_angle_index"])
            .into_iter()
            .enumerate()
        {
            let (got, want) = (label.pdp_angle_deg[i], angles[at as usize]);
            equal += usize::from(got == want);
            assert_power(
                q(delays[i], got),
                q(delays[i], want),
                total,
                &format!("{}: angle {i}", scene["name"]),
            );
        }
        all += label.aps_delay_s.len() + label.pdp_angle_deg.len();
    }
    assert!(
        equal * 100 > all * 95,
        "{equal} of {all} places are the same"
    );
}

#[test]
fn single_elements_agree_with_sixty_digits() {
    let golden = golden();
    let scenes = golden["scenes"].as_array().expect("scenes");
    for point in golden["exact"].as_array().expect("points") {
        let protocol: Protocol = point["protocol"]
            .as_str()
            .expect("a name")
            .parse()
            .expect("known");
        let paths = paths(&scenes[point["scene"].as_u64().expect("an index") as usize]);
        let number = |name: &str| point[name].as_f64().expect("a number");
        let got = labeler(protocol)
            .q(&paths, number("tau_s"), number("theta_deg").to_radians())
            .expect("finite");
        assert_power(
            got,
            number("q"),
            total_power(protocol, &paths),
            &point.to_string(),
        );
    }
}

#[test]
fn released_maxima_agree_with_sixty_digits() {
    let golden = golden();
    let scenes = golden["scenes"].as_array().expect("scenes");
    let mut worst_db = 0.0_f64;
    for case in golden["exact_maxima"].as_array().expect("cases") {
        let scene = &scenes[case["scene"].as_u64().expect("an index") as usize];
        let paths = paths(scene);
        let label = labeler(Protocol::Released)
            .label(&paths)
            .expect("good paths")
            .expect("a label");
        let total = total_power(Protocol::Released, &paths);
        for (bin, q) in numbers(&case["bins"]).into_iter().zip(numbers(&case["q"])) {
            let (got, want) = (label.aps_db[bin as usize], 10.0 * (q + 1e-35).log10());
            assert_power_db(got, want, total, &format!("{}: bin {bin}", scene["name"]));
            if q > 1e-10 * total {
                worst_db = worst_db.max((got - want).abs());
            }
        }
    }
    // Down to 100 dB below the link's power the tolerance is not needed at all.
    assert!(worst_db < 1e-11, "{worst_db:e} dB");
}

#[test]
fn released_drops_gain_and_losses_beyond_310_db() {
    let golden = golden();
    let scenes = golden["scenes"].as_array().expect("scenes");
    let scene = scenes
        .iter()
        .find(|s| s["name"] == "dropped by the released protocol");
    let paths = paths(scene.expect("the scene"));
    let labeler = labeler(Protocol::Released);
    let kept = labeler.label(&paths[3..]).expect("good paths");
    assert_eq!(labeler.label(&paths).expect("good paths"), kept);
    assert_eq!(labeler.label(&paths[..3]).expect("good paths"), None);
    let strongest = kept
        .expect("a label")
        .aps_db
        .into_iter()
        .fold(f64::MIN, f64::max);
    assert!(linear(strongest) > 0.0);
}
