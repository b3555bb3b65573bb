//! Differences between the labels that a model learnt and those that it is asked about.

use std::fmt;

use aps_label::Protocol;
use serde_json::Value;

use crate::limits::has_legs_between_corners;

/// Settings of the trace that decide which paths a label is made of, and how strong they are.
const TRACE: [&str; 7] = [
    "frequency_hz",
    "material",
    "max_reflections",
    "max_diffractions",
    "max_interactions",
    "max_fallback_diffractions",
    "dynamic_range_db",
];

/// A setting of which a model's labels and those of a data set differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Its name, as manifests have it: `protocol`, `array`, `max_diffractions`, ...; `trace` where one of both tells no limits.
    pub setting: &'static str,
    /// Its value in the training; null if that is not told.
    pub learnt: Value,
    /// Its value in the data set; null if that is not told.
    pub found: Value,
}

impl Difference {
    /// Compares the settings that spectra depend on: protocol, array, sampling rate, carrier, material and limits. `protocol` is
    /// that by which the training took its labels, `learnt` the configuration of the data set that was trained on, `found` that
    /// of another. Settings of power delay profiles are left out, which no spectrum depends on, and so is slope diffraction
    /// where paths have one corner at most.
    pub fn all(protocol: Protocol, learnt: &Value, found: &Value) -> Vec<Self> {
        let of = |group: &str, setting: &'static str| Self {
            setting,
            learnt: learnt[group][setting].clone(),
            found: found[group][setting].clone(),
        };
        let mut all = vec![
            Self {
                learnt: protocol.name().into(),
                ..of("label", "protocol")
            },
            of("label", "array"),
            of("label", "sampling_rate_hz"),
        ];
        if protocol == Protocol::Released {
            // Its spectra are the largest of those at the sampled delays.
            all.push(of("label", "delay_axis"));
        }
        match [learnt, found].iter().all(|side| side["trace"].is_object()) {
            true => all.extend(TRACE.map(|setting| of("trace", setting))),
            false => all.push(Self {
                setting: "trace",
                learnt: learnt["trace"].clone(),
                found: found["trace"].clone(),
            }),
        }
        let has_legs = |side: &Value| {
            let most = |name: &str| side["trace"][name].as_u64().unwrap_or(0) as usize;
            has_legs_between_corners(most("max_diffractions"), most("max_interactions"))
        };
        if has_legs(learnt) && has_legs(found) {
            // Manifests have it where it is on.
            let is_on = |side: &Value| side["trace"]["slope_diffraction"] == true;
            all.push(Self {
                setting: "slope_diffraction",
                learnt: is_on(learnt).into(),
                found: is_on(found).into(),
            });
        }
        all.retain(|difference| difference.learnt != difference.found);
        all
    }

    /// True if the same spectrum means something else there: angles half a turn away, or another array's answer.
    pub fn is_of_meaning(&self) -> bool {
        let is_told = !self.learnt.is_null() && !self.found.is_null();
        is_told && matches!(self.setting, "protocol" | "array")
    }
}

/// `max_diffractions: 1 in the training, 2 here`.
impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let told = |value: &Value| match value {
            Value::Null => "not told".to_owned(),
            Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        let (learnt, found) = (told(&self.learnt), told(&self.found));
        write!(
            f,
            "{}: {learnt} in the training, {found} here",
            self.setting
        )
    }
}

#[cfg(test)]
mod tests {
    use aps_label::{Array, LabelConfig};
    use aps_raytrace::{Material, TraceConfig};
    use serde_json::json;

    use super::*;
    use crate::maps::SceneSettings;
    use crate::sampling::Sampling;
    use crate::settings;

    /// The configuration of a data set as its manifest has it.
    fn configuration(label: &LabelConfig, trace: &TraceConfig) -> Value {
        let sampling = Sampling {
            tx_per_map: 1,
            rx_per_map: 1,
            grid_m: 1.0,
            receivers: crate::sampling::Receivers::Reached,
        };
        let scene = SceneSettings::default();
        settings::of_traced(json!("synthetic"), scene, sampling, trace, label)
    }

    fn names(learnt: (&LabelConfig, &TraceConfig), found: (&LabelConfig, &TraceConfig)) -> String {
        let [a, b] = [learnt, found].map(|(label, trace)| configuration(label, trace));
        let all = Difference::all(learnt.0.protocol, &a, &b);
        let names: Vec<&str> = all.iter().map(|difference| difference.setting).collect();
        names.join(" ")
    }

    /// Changes a setting; with the name of the difference that this is, empty for none.
    type Change<T> = (fn(&mut T), &'static str);

    const EIGHT: Array = Array::UniformLinear {
        elements: 8,
        spacing_wavelengths: 0.5,
    };

    #[test]
    fn every_setting_that_spectra_depend_on_is_a_difference() {
        let (label, trace) = (LabelConfig::paper(), TraceConfig::default());
        let labels: [Change<LabelConfig>; 5] = [
            (|l| *l = LabelConfig::released(), "protocol"),
            (|l| l.array = EIGHT, "array"),
            (|l| l.sampling_rate_hz = 1e8, "sampling_rate_hz"),
            (|l| l.pdp = true, ""),
            (|_| (), ""),
        ];
        for (change, expected) in labels {
            let mut other = label.clone();
            change(&mut other);
            assert_eq!(names((&label, &trace), (&other, &trace)), expected);
        }
        let usual = TraceConfig {
            max_diffractions: 1,
            slope_diffraction: true,
            ..trace.clone()
        };
        let traces: [Change<TraceConfig>; 9] = [
            (|t| t.frequency_hz = 28e9, "frequency_hz"),
            (|t| t.material = Material::PerfectConductor, "material"),
            (|t| t.max_reflections = 4, "max_reflections"),
            (|t| t.max_interactions = 5, "max_interactions"),
            (
                |t| t.max_fallback_diffractions = 3,
                "max_fallback_diffractions",
            ),
            (|t| t.dynamic_range_db = None, "dynamic_range_db"),
            (|t| t.max_diffractions = 2, "max_diffractions"),
            (
                |t| (t.max_diffractions, t.slope_diffraction) = (2, false),
                "max_diffractions",
            ),
            (|t| t.slope_diffraction = false, ""),
        ];
        for (change, expected) in traces {
            let mut other = usual.clone();
            change(&mut other);
            assert_eq!(names((&label, &usual), (&label, &other)), expected);
        }
        let on = TraceConfig {
            max_diffractions: 2,
            ..usual
        };
        let off = TraceConfig {
            slope_diffraction: false,
            ..on.clone()
        };
        assert_eq!(names((&label, &on), (&label, &off)), "slope_diffraction");
        let single = TraceConfig {
            max_interactions: 1,
            ..on.clone()
        };
        assert_eq!(names((&label, &on), (&label, &single)), "max_interactions");
        // The delays decide the spectra of the released definition alone.
        for (label, expected) in [(label, ""), (LabelConfig::released(), "delay_axis")] {
            let mut other = label.clone();
            other.delay_axis.points = 64;
            assert_eq!(names((&label, &trace), (&other, &trace)), expected);
        }
    }

    #[test]
    fn only_told_protocols_and_arrays_change_the_meaning() {
        let configuration = json!({ "label": { "protocol": "released", "array": "a" }, "trace": { "frequency_hz": 1.0 } });
        let all = Difference::all(
            Protocol::Paper,
            &json!({ "label": { "array": "b" } }),
            &configuration,
        );
        let told: Vec<(String, bool)> = all
            .iter()
            .map(|d| (d.to_string(), d.is_of_meaning()))
            .collect();
        let expected = [
            ("protocol: paper in the training, released here", true),
            ("array: b in the training, a here", true),
            (
                "trace: not told in the training, {\"frequency_hz\":1.0} here",
                false,
            ),
        ];
        assert_eq!(
            told,
            expected.map(|(text, meaning)| (text.to_owned(), meaning))
        );
        // Labels that tell nothing, and settings that are none at all.
        for foreign in [json!({}), json!(null), json!("text"), json!([1])] {
            let all = Difference::all(Protocol::Paper, &configuration, &foreign);
            assert!(!all.is_empty() && !all.iter().any(Difference::is_of_meaning));
        }
    }
}
