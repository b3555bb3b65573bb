//! Against values made by `tests/golden/label.py`: NumPy's straightforward formula, and single
//! elements of Q in 60 digits.

use crate::common::{
    MAXIMUM_ERROR, assert_power, assert_power_db, label, labeler, linear, tolerance, total_power,
};
use aps_label::{PathSample, Protocol};
use serde_json::Value;

const GOLDEN: &str = include_str!("../../../../tests/golden/label.json");

/// One of the file's lists.
fn golden(list: &str) -> Vec<Value> {
    let mut file: Value = serde_json::from_str(GOLDEN).expect("label.json is JSON");
    serde_json::from_value(file[list].take()).expect("a list")
}

fn numbers(value: &Value) -> Vec<f64> {
    serde_json::from_value(value.clone()).expect("a list of numbers")
}

fn paths(scene: &Value) -> Vec<PathSample> {
    let rows: Vec<[f64; 3]> = serde_json::from_value(scene["paths"].clone()).expect("rows");
    let path = |[delay_s, arrival_azimuth_rad, gain_db]: [f64; 3]| PathSample {
        delay_s,
        arrival_azimuth_rad,
        gain_db,
    };
    rows.into_iter().map(path).collect()
}

#[test]
fn powers_agree_with_numpy() {
    for scene in golden("scenes") {
        let paths = paths(&scene);
        for protocol in Protocol::ALL {
            let what = format!("{protocol}, {}", scene["name"]);
            let want = &scene[protocol.to_string()];
            let label = label(&labeler(protocol), &paths);
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
    for scene in golden("scenes") {
        let paths = paths(&scene);
        let total = total_power(Protocol::Released, &paths);
        let label = label(&labeler, &paths);
        let q = |tau, theta: f64| labeler.q(&paths, tau, theta.to_radians()).expect("finite");
        let mut check = |what: String, places: [f64; 2], q: &dyn Fn(f64) -> f64| {
            let [got, want] = places;
            equal += usize::from(got == want);
            assert_power(
                q(got),
                q(want),
                total,
                &format!("{}: {what}", scene["name"]),
            );
        };
        let indices = |name: &str| numbers(&scene["released"][name]).into_iter();
        for (j, at) in indices("aps_delay_index").enumerate() {
            let places = [label.aps_delay_s[j], delays[at as usize]];
            check(format!("delay {j}"), places, &|tau| q(tau, angles[j]));
        }
        for (i, at) in indices("pdp_angle_index").enumerate() {
            let places = [label.pdp_angle_deg[i], angles[at as usize]];
            check(format!("angle {i}"), places, &|theta| q(delays[i], theta));
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
    let scenes = golden("scenes");
    for point in golden("exact") {
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
    let scenes = golden("scenes");
    let mut worst_db = 0.0_f64;
    for case in golden("exact_maxima") {
        let scene = &scenes[case["scene"].as_u64().expect("an index") as usize];
        let paths = paths(scene);
        let label = label(&labeler(Protocol::Released), &paths);
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
    let scenes = golden("scenes");
    let is_meant = |scene: &&Value| scene["name"] == "dropped by the released protocol";
    let paths = paths(scenes.iter().find(is_meant).expect("the scene"));
    let labeler = labeler(Protocol::Released);
    let kept = labeler.label(&paths[3..]).expect("good paths");
    assert_eq!(labeler.label(&paths).expect("good paths"), kept);
    assert_eq!(labeler.label(&paths[..3]).expect("good paths"), None);
    let aps_db = kept.expect("a label").aps_db;
    assert!(linear(aps_db.into_iter().fold(f64::MIN, f64::max)) > 0.0);
}
