//! Training: batches prepared ahead, forward pass, loss, update; checkpoints that continue bit for bit.
//!
//! A [`Trainer`] is driven step by step, so that its caller decides when to evaluate on the development set, what to log and
//! when to stop:
//!
//! ```
//! # use aps_model::candle_core::{DType, Device};
//! # use aps_model::condition::{ConditionConfig, ConditionImages, Link, ModelInput, Rasters};
//! # use aps_model::data::Samples;
//! # let device = Device::Cpu;
//! # let rasters = Rasters { pixels: &[0.0; 1024], height: 32, width: 32, metres_per_pixel: 1.0 };
//! # let images = ConditionConfig { image_size: 32, sigma_px: 2.0, ..ConditionConfig::default() };
//! # let links: Vec<Link> = (0..4).map(|i| Link { map: 0, tx_m: [i as f64, 3.0], rx_m: [9.0, 9.0] }).collect();
//! # let examples = Box::new(Samples::new(links, vec![1.0; 4 * 180])?);
//! use aps_model::candle_nn::VarMap;
//! use aps_model::train::{TrainConfig, Trainer};
//! use aps_model::{ModelKind, Preset, seeded};
//!
//! let (kind, parameters) = (ModelKind::ResnetMlp, VarMap::new());
//! let input = Box::new(ConditionImages::new(rasters, images, &device)?);
//! let vb = seeded(&parameters, 42, DType::F32, &device);
//! let model = kind.build(Preset::Small, input.shape(), vb)?;
//! let config = TrainConfig { epochs: 2, batch: 2, ..kind.train_config(Preset::Small) };
//! let mut trainer = Trainer::new(model, &parameters, kind.loss(), input, examples, config)?;
//! while let Some(report) = trainer.step()? {
//!     println!("step {}: loss {}", report.step, report.loss);
//! }
//! assert_eq!(trainer.steps_done(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # One step
//!
//! Without a regularizer a step is: the model's input and the targets of a batch, a forward pass, the model's
//! [`Loss`](crate::Loss), an update by [`AdamW`](crate::optim::AdamW). With one (the paper's equations for L_R and L_P):
//!
//! 1. predict the spectra of the batch;
//! 2. update the regularizer, which is trained to score true pairs of image and spectrum 1 and predicted ones 0; the
//!    prediction is detached;
//! 3. update the predictor by the score of its spectra under the updated regularizer, and `l1_weight` times the mean absolute
//!    error.
//!
//! The regularizer encodes the images once for both halves of (2), and in (3) its encoding is a constant to the
//! predictor: the same gradients for a third of the work. Gradients of each network are clipped; the learning rate rises
//! over the first steps and falls linearly to zero.
//!
//! A training ends after [`TrainConfig::epochs`], or after a time, [`TrainConfig::budget_s`]: the learning rate then follows the
//! share of the time that is spent, and a checkpoint keeps that time, so that a continued training gets what is left.
//!
//! # Precision
//!
//! [`Precision::Mixed`] computes in bf16 with weights, normalisations, sums, losses and gradients of weights in f32, as PyTorch's
//! autocast does, and is as far from f32 as that: of small models with random weights 0.2 to 1 % of a spectrum, and 0.8 to 37 % of
//! the gradients of 16 links (a test holds each model to PyTorch's figure). Development links are scored in f32.
//!
//! # The same bytes
//!
//! Order of the examples and dropout are functions of seed, epoch and step, so that there is no state of a generator to
//! save. A run that was stopped after any step and continued from its [checkpoint](Trainer::save) gives the same weights
//! as one that was not, bit for bit, on a CPU with any number of threads. On a GPU sums may be ordered differently each time.

mod batches;
mod checkpoint;
mod clock;
mod config;
mod error;
mod held;
mod predict;
mod schedule;
mod trainer;

pub use config::{Precision, TrainConfig};
pub use error::TrainError;
pub use predict::predict;
#[cfg(test)]
pub(crate) use schedule::{Budget, Schedule};
pub use trainer::{Held, StepReport, Trainer};
