//! Golden files, and how close is close.

use std::collections::HashMap;
use std::path::Path;

use candle_core::{Device, Tensor, safetensors};

use super::super::flat;
use super::rule::mix;

/// Sampled elements a tensor.
const SAMPLES: usize = 4;

/// The arrays of one model.
pub struct Golden {
    model: String,
    arrays: HashMap<String, Tensor>,
}

impl Golden {
    pub fn of(model: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../tests/golden/models")
            .join(format!("{model}.safetensors"));
        Self {
            model: model.into(),
            arrays: safetensors::load(path, &Device::Cpu).unwrap(),
        }
    }

    pub fn values(&self, name: &str) -> Vec<f64> {
        flat(&self.arrays[name])
    }

    /// Checks every element of `found` to `tolerance`, absolute.
    pub fn check_absolute(&self, name: &str, found: &Tensor, tolerance: f64) {
        let model = &self.model;
        let expected = self.arrays[name].dims();
        assert_eq!(found.dims(), expected, "{model}, {name}");
        let expected = self.values(name).into_iter();
        let errors = expected.zip(flat(found)).map(|(e, f)| (e - f).abs());
        let worst = errors.fold(0.0, f64::max);
        println!("{model}, {name}: off by at most {worst:.2e}");
        assert!(worst <= tolerance, "{model}, {name}: off by {worst:e}");
    }

    /// Norm and samples of each of the tensors, in the order of their names.
    pub fn rows(&self, name: &str, tensors: &[(String, Tensor)]) -> Vec<Row> {
        let expected = self.values(name);
        let count = tensors.len() * (1 + SAMPLES);
        assert_eq!(expected.len(), count, "{name}: number of tensors");
        let row = |((tensor, found), expected): (&(String, Tensor), &[f64])| {
            let found = flat(found);
            let name = format!("sample {tensor}");
            let samples = mix(&name, SAMPLES).map(|at| found[(at % found.len() as u64) as usize]);
            Row {
                tensor: tensor.clone(),
                rms: expected[0] / (found.len() as f64).sqrt(),
                norm: (expected[0], found.iter().map(|v| v * v).sum::<f64>().sqrt()),
                samples: expected[1..].iter().copied().zip(samples).collect(),
            }
        };
        let expected = expected.chunks(1 + SAMPLES);
        tensors.iter().zip(expected).map(row).collect()
    }
}

/// Comparison of one tensor; each pair is (expected, found).
pub struct Row {
    pub tensor: String,
    /// Root of the mean square of the expected values.
    pub rms: f64,
    pub norm: (f64, f64),
    pub samples: Vec<(f64, f64)>,
}

impl Row {
    /// Norm and samples, each with the size that its error is relative to: an element of the tensor, or all of it.
    pub fn pairs(&self) -> impl Iterator<Item = (f64, (f64, f64))> {
        let samples = self.samples.iter().map(|&pair| (self.rms, pair));
        samples.chain([(self.norm.0, self.norm)])
    }
}
