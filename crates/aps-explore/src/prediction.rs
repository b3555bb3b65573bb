//! The spectrum that the shipped model predicts for a link, beside its label.

use std::time::Instant;

use aps_label::{Array, LabelConfig};
use aps_raytrace::TraceConfig;
use aps_raytrace::polar::Mirror;
use aps_report::link::Spectrum;
use map2aps::SeenLink;
use map2aps::error::chain;
use map2aps::training::LinkModel;
use serde::Serialize;

use crate::cache::{Cache, City};
use crate::curve::Curve;
use crate::fault::Fault;
use crate::request::LinkQuestion;
use crate::times::us;

/// Least power that is drawn, over that of the strongest direction: a prediction may be negative.
const LEAST: f64 = 1e-6;

/// A prediction, or the reason why there is none.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum Prediction {
    /// A prediction and its scores against the label that is shown.
    Made {
        /// The spectrum, at the level of the label: the model predicts none.
        curve: Curve,
        /// Cosine similarity.
        cosine: f64,
        /// Mean absolute error, normalised as for the training.
        mae: f64,
        /// True when the label is of other limits or walls than those that the model learnt.
        is_foreign: bool,
        /// Times \[us\]: of the link, and of the map, whose geometry is prepared once.
        times_us: [f64; 2],
    },
    /// The setting that the model does not know, or the geometry that has no place in it.
    Missing {
        /// The reason in words.
        reason: String,
    },
}

impl Prediction {
    /// Predicts a link whose label is `spectrum`.
    ///
    /// # Errors
    /// Shipped weights that cannot be read.
    pub fn of(
        cache: &Cache,
        city: &City,
        question: &LinkQuestion,
        spectrum: &Spectrum,
    ) -> Result<Self, Fault> {
        let model = cache.model()?;
        let trace = question.trace.config()?;
        if let Some(known) = unknown(&model, &question.label.config()?, &trace, question) {
            return Ok(Self::Missing {
                reason: format!("it knows only {known}"),
            });
        }
        let made = Self::made(cache, city, &model, question, spectrum);
        Ok(made.unwrap_or_else(|fault| Self::Missing {
            reason: chain(&fault),
        }))
    }

    fn made(
        cache: &Cache,
        city: &City,
        model: &LinkModel,
        question: &LinkQuestion,
        spectrum: &Spectrum,
    ) -> Result<Self, Fault> {
        let views = cache.views(city)?;
        let began = Instant::now();
        let link = SeenLink {
            map: 0,
            tx_m: question.tx,
            rx_m: question.rx,
            mirror: Mirror::default(),
        };
        let predict = || model.predict(&views.value, &[link]);
        let mut predicted = cache.on_all_threads(predict)?;
        let predicted = predicted.pop().ok_or(Fault::Broken)?;
        let scores = predicted.score(&spectrum.aps_db)?;
        let top_db = spectrum.top_db();
        let level_db = |power: f64| top_db + 10.0 * power.max(LEAST).log10();
        let curve = Spectrum {
            aps_db: predicted.relative_power().map(level_db).collect(),
            delay_s: Vec::new(),
            pdp: Vec::new(),
            ..spectrum.clone()
        };
        Ok(Self::Made {
            curve: Curve::of(&curve, spectrum.protocol),
            cosine: scores.cosine,
            mae: scores.mae,
            is_foreign: is_foreign(model.trace(), &question.trace.config()?),
            times_us: [us(began.elapsed()), us(views.took)],
        })
    }
}

/// Returns the first setting that leaves no meaning to a prediction, as the model knows it.
fn unknown(
    model: &LinkModel,
    label: &LabelConfig,
    trace: &TraceConfig,
    question: &LinkQuestion,
) -> Option<String> {
    let own = model.label();
    if own.protocol != label.protocol {
        Some(format!("protocol {}", own.protocol))
    } else if own.array != label.array {
        Some(match own.array {
            Array::UniformLinear {
                elements,
                spacing_wavelengths,
            } => format!("a linear array of {elements} elements, {spacing_wavelengths} λ apart"),
            _ => "an array of another form".into(),
        })
    } else if question.label.heading_deg != 0.0 {
        Some("an array of heading 0°".into())
    } else if own.sampling_rate_hz != label.sampling_rate_hz {
        Some(format!("a bandwidth of {} MHz", own.sampling_rate_hz / 1e6))
    } else if model.trace().frequency_hz != trace.frequency_hz {
        let carrier_ghz = model.trace().frequency_hz / 1e9;
        Some(format!("a carrier of {carrier_ghz} GHz"))
    } else {
        None
    }
}

/// Returns true for limits and walls that the model did not learn.
fn is_foreign(own: &TraceConfig, chosen: &TraceConfig) -> bool {
    // With one corner at most there is no slope.
    let has_slopes = chosen.max_diffractions.min(chosen.max_interactions) > 1;
    let own = TraceConfig {
        max_images: chosen.max_images,
        max_wave_bytes: chosen.max_wave_bytes,
        slope_diffraction: match has_slopes {
            true => own.slope_diffraction,
            false => chosen.slope_diffraction,
        },
        ..own.clone()
    };
    own != *chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_other_limits_only_where_there_are_two_corners() {
        for (max_diffractions, max_interactions, tells) in
            [(0, 3, false), (1, 3, false), (2, 1, false), (2, 3, true)]
        {
            let own = TraceConfig {
                max_diffractions,
                max_interactions,
                ..TraceConfig::default()
            };
            let other = TraceConfig {
                slope_diffraction: !own.slope_diffraction,
                max_images: 1,
                ..own.clone()
            };
            let foreign = is_foreign(&own, &other);
            assert_eq!(foreign, tells, "{max_diffractions}, {max_interactions}");
            assert!(!is_foreign(&own, &own));
        }
        let own = TraceConfig::default();
        let other = TraceConfig {
            max_reflections: 3,
            slope_diffraction: false,
            ..own.clone()
        };
        assert!(is_foreign(&own, &other));
    }
}
