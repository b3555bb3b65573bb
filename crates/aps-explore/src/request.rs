//! The questions of the page, as JSON, checked.

use aps_label::{ArrayForm, HEADINGS_DEG, LabelConfig, Protocol};
use aps_raytrace::TraceConfig;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::fault::Fault;
use crate::houses::Edits;
use crate::limits::{
    DIFFRACTIONS, ELEMENTS, MANY_DIFFRACTIONS_RANGE_DB, MAX_IMAGES, MAX_WAVE_BYTES, REFLECTIONS,
};

/// A map, perhaps changed.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CityQuestion {
    /// Number of the map.
    pub map: u32,
    /// Its changes.
    #[serde(default)]
    pub houses: Edits,
}

/// A link in it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkQuestion {
    /// The map.
    pub city: CityQuestion,
    /// Transmitter \[m\].
    pub tx: [f64; 2],
    /// Receiver \[m\].
    pub rx: [f64; 2],
    /// Settings of the tracer.
    pub trace: TraceChoice,
    /// Settings of the label.
    pub label: LabelChoice,
    /// If true, the prediction of the shipped model is wanted too.
    #[serde(default)]
    pub model: bool,
}

/// Question about a transmitter's coverage of the map.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoverageQuestion {
    /// The map.
    pub city: CityQuestion,
    /// Transmitter \[m\].
    pub tx: [f64; 2],
    /// Settings of the tracer.
    pub trace: TraceChoice,
    /// Settings of the label.
    pub label: LabelChoice,
    /// The quantity to compute.
    pub show: Show,
    /// Side of a cell \[m\].
    pub cell_m: f64,
}

/// Quantities of a coverage map: those that one trace gives, or the distance from a second one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Show {
    /// Level, number of paths, line of sight and the direction of the strongest path.
    Link,
    /// Error of the spectrum against the reference limits.
    Error,
}

/// Settings of the tracer that the page can change.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TraceChoice {
    /// Most reflections on a path.
    pub reflections: usize,
    /// Most diffractions on a path.
    pub diffractions: usize,
    /// Waves from corner to corner take their slope along.
    pub slope_diffraction: bool,
    /// Paths are left out below the strongest by this \[dB\]; none keeps all.
    pub dynamic_range_db: Option<f64>,
    /// Carrier \[Hz\].
    pub frequency_hz: f64,
    /// Walls, as the command line has them: `concrete`, `pec` or `EPS,SIGMA`.
    pub material: String,
}

/// Settings of the label that the page can change.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelChoice {
    /// Definition of the label.
    pub protocol: Protocol,
    /// Form of the array.
    pub array: ArrayForm,
    /// Its elements.
    pub elements: usize,
    /// Their spacing, on a circle along its arc \[wavelengths\].
    pub spacing: f64,
    /// Turn of the array, counter-clockwise \[deg\].
    pub heading_deg: f64,
    /// Bandwidth-related sampling rate \[Hz\].
    pub sampling_rate_hz: f64,
}

/// Reads a question.
///
/// # Errors
/// [`Fault::Form`], with the place of the fault.
pub fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, Fault> {
    let mut json = serde_json::Deserializer::from_slice(body);
    let form = |error: &dyn std::fmt::Display| Fault::Form(error.to_string());
    let question = serde_path_to_error::deserialize(&mut json).map_err(|e| form(&e))?;
    json.end().map_err(|e| form(&e))?;
    Ok(question)
}

impl TraceChoice {
    /// The tracer's configuration.
    ///
    /// # Errors
    /// Settings outside of their ranges.
    pub fn config(&self) -> Result<TraceConfig, Fault> {
        let limit = |name, value: usize, most: usize| {
            Fault::range(name, value as f64, 0.0..=most as f64).map(|()| value)
        };
        let max_reflections = limit("reflections", self.reflections, REFLECTIONS)?;
        let max_diffractions = limit("diffractions", self.diffractions, DIFFRACTIONS)?;
        let config = TraceConfig {
            slope_diffraction: self.slope_diffraction,
            dynamic_range_db: self.dynamic_range_db,
            ..self.under(TraceConfig::within(max_reflections, max_diffractions))?
        };
        config.validate().map_err(Fault::of)?;
        let range_db = config.dynamic_range_db.unwrap_or(f64::INFINITY);
        if max_diffractions > 2 && range_db > MANY_DIFFRACTIONS_RANGE_DB {
            return Err(Fault::Endless);
        }
        Ok(config)
    }

    /// R5 D2 within 30 dB for the same carrier and walls: the limits that others are compared with.
    ///
    /// # Errors
    /// As [`Self::config`].
    pub fn reference(&self) -> Result<TraceConfig, Fault> {
        let config = self.under(TraceConfig {
            dynamic_range_db: Some(30.0),
            ..TraceConfig::converged()
        })?;
        config.validate().map_err(Fault::of)?;
        Ok(config)
    }

    /// The limits of another configuration, with the carrier and walls of this one.
    fn under(&self, limits: TraceConfig) -> Result<TraceConfig, Fault> {
        Ok(TraceConfig {
            frequency_hz: self.frequency_hz,
            material: self.material.parse().map_err(Fault::Material)?,
            max_images: MAX_IMAGES,
            max_wave_bytes: MAX_WAVE_BYTES,
            ..limits
        })
    }
}

impl LabelChoice {
    /// The label's configuration, with a delay profile.
    ///
    /// # Errors
    /// Settings outside of their ranges.
    pub fn config(&self) -> Result<LabelConfig, Fault> {
        Fault::range("heading_deg", self.heading_deg, HEADINGS_DEG)?;
        Fault::range("elements", self.elements as f64, 1.0..=ELEMENTS as f64)?;
        let config = LabelConfig {
            sampling_rate_hz: self.sampling_rate_hz,
            array: self.array.array(self.elements, self.spacing),
            pdp: true,
            ..LabelConfig::of(self.protocol)
        };
        config.validate().map_err(Fault::of)?;
        Ok(config)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// A question about a link of synthetic city 0.
    pub fn question() -> Value {
        json!({
            "city": { "map": 0 },
            "tx": [45.5, 75.0],
            "rx": [122.0, 80.0],
            "trace": {
                "reflections": 2, "diffractions": 1, "slope_diffraction": true, "dynamic_range_db": 60.0,
                "frequency_hz": 3.5e9, "material": "concrete",
            },
            "label": {
                "protocol": "paper",
                "array": "ula", "elements": 16, "spacing": 0.5,
                "heading_deg": 0.0, "sampling_rate_hz": 200e6,
            },
        })
    }

    fn check(question: &Value) -> Result<(), Fault> {
        let read: LinkQuestion = read(question.to_string().as_bytes())?;
        read.trace.config()?;
        read.label.config()?;
        Ok(())
    }

    #[test]
    fn question_as_of_the_page_means_r2_d1_and_the_label_of_the_command_line() {
        let question: LinkQuestion = read(question().to_string().as_bytes()).unwrap();
        let expected = TraceConfig {
            max_images: MAX_IMAGES,
            max_wave_bytes: MAX_WAVE_BYTES,
            ..TraceConfig::default()
        };
        assert_eq!(question.trace.config().unwrap(), expected);
        let expected = LabelConfig {
            pdp: true,
            ..LabelConfig::paper()
        };
        assert_eq!(question.label.config().unwrap(), expected);
    }

    #[test]
    fn settings_out_of_range_are_named() {
        for (pointer, value, told) in [
            ("/trace/reflections", json!(7), "reflections = 7"),
            ("/trace/reflections", json!(u64::MAX), "reflections"),
            ("/trace/diffractions", json!(4), "diffractions = 4"),
            ("/trace/dynamic_range_db", json!(-1.0), "dynamic range"),
            ("/trace/frequency_hz", json!(0.0), "carrier"),
            ("/trace/material", json!("gold"), "material: 'gold'"),
            ("/trace/material", json!("NaN,1"), "material"),
            ("/label/heading_deg", json!(1e300), "heading_deg"),
            (
                "/label/sampling_rate_hz",
                json!(0.0),
                "sampling_rate_hz = 0",
            ),
            ("/label/elements", json!(4096), "elements"),
            ("/label/spacing", json!(-0.5), "spacing"),
            ("/label/protocol", json!("mine"), "label.protocol"),
            ("/tx", json!([1.0, null]), "tx[1]"),
            ("/tx", json!([1.0]), "tx"),
            ("/city/map", json!(-1), "city.map"),
            ("/city/houses", json!({ "burnt": [] }), "burnt"),
        ] {
            let mut question = question();
            match question.pointer_mut(pointer) {
                Some(place) => *place = value,
                None => question["city"]["houses"] = value,
            }
            let message = check(&question).unwrap_err().reply();
            let message = serde_json::to_string(&message).unwrap();
            assert!(message.contains(told), "{pointer}: {message}");
        }
    }

    #[test]
    fn three_diffractions_need_a_dynamic_range() {
        for (diffractions, range_db, is_good) in [
            (2, json!(null), true),
            (2, json!(130.0), true),
            (3, json!(60.0), true),
            (3, json!(60.5), false),
            (3, json!(null), false),
        ] {
            let mut question = question();
            question["trace"]["diffractions"] = diffractions.into();
            question["trace"]["dynamic_range_db"] = range_db.clone();
            let checked = check(&question);
            assert_eq!(checked.is_ok(), is_good, "{diffractions}, {range_db}");
            assert!(matches!(checked, Ok(()) | Err(Fault::Endless)));
        }
    }

    #[test]
    fn text_that_is_no_json_is_refused() {
        for text in [
            "",
            "[",
            "{\"city\": NaN}",
            "null",
            "{\"city\":{\"map\":1e999}}",
            "\u{0}",
            "[[[[[[[[",
        ] {
            let fault = read::<LinkQuestion>(text.as_bytes()).unwrap_err();
            assert!(matches!(fault, Fault::Form(_)), "{text}");
        }
        let deep = "[".repeat(1_000_000);
        assert!(read::<LinkQuestion>(deep.as_bytes()).is_err());
        let two = format!("{0} {0}", question());
        assert!(read::<LinkQuestion>(two.as_bytes()).is_err());
    }
}
