//! Training: two recipes, batches prepared ahead, checkpoints that continue bit for bit.
//!
//! A [`Trainer`] is driven step by step, so that whoever drives it decides when to look at the development set, what to
//! write down and when to stop:
//!
//! ```
//! # use aps_model::{Init, Mode, Model, Parameters, Result, candle_core::{DType, Device, Tensor}};
//! # use aps_model::condition::{ConditionConfig, Conditions, Link, Rasters};
//! # use aps_model::data::Samples;
//! # #[derive(Debug)]
//! # struct Tiny { parameters: Parameters, weight: Tensor }
//! # impl Model for Tiny {
//! #     fn forward(&self, images: &Tensor, _: Mode<'_>) -> Result<Tensor> {
//! #         Ok(images.flatten_from(1)?.matmul(&self.weight)?)
//! #     }
//! #     fn parameters(&self) -> &Parameters { &self.parameters }
//! # }
//! # let device = Device::Cpu;
//! # let parameters = Parameters::new(&device, DType::F32, 0);
//! # let weight = parameters.root().trainable("weight", (3 * 16 * 16, 180), Init::Constant(0.0))?;
//! # let model = Tiny { parameters, weight };
//! # let rasters = Rasters { pixels: &[0.0; 256], height: 16, width: 16, metres_per_pixel: 1.0 };
//! # let config = ConditionConfig { image_size: 16, sigma_px: 2.0 };
//! # let conditions = Conditions::new(rasters, config, &device)?;
//! # let links: Vec<Link> = (0..8).map(|i| Link { map: 0, tx_m: [i as f64, 3.0], rx_m: [9.0, 9.0] }).collect();
//! # let examples = Samples::new(links, vec![1.0; 8 * 180])?;
//! use aps_model::train::{Trainees, TrainConfig, Trainer};
//! let config = TrainConfig { epochs: 2, batch: 4, learning_rate: 1e-2, ..TrainConfig::regression() };
//! let trainees = Trainees { predictor: Box::new(model), regularizer: None };
//! let mut trainer = Trainer::new(trainees, conditions, examples, config)?;
//! while let Some(report) = trainer.step()? {
//!     println!("step {}: loss {}", report.step, report.loss);
//! }
//! assert_eq!(trainer.steps_done(), 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Recipes
//!
//! Without a regularizer: mean squared error, AdamW. With one, each step (the paper's equations for L_R and L_P):
//!
//! 1. predict the spectra of the batch;
//! 2. one step of the regularizer, which shall score true pairs of image and spectrum 1 and predicted ones 0; the
//!    prediction is detached;
//! 3. one step of the predictor on the score of its spectra by the moved regularizer, and `l1_weight` times the mean
//!    absolute error.
//!
//! The regularizer encodes the images once for both halves of (2), and in (3) its encoding is a constant to the
//! predictor: the same gradients for a third of the work. Gradients of each network are clipped, learning rates go up
//! and down by one [schedule](crate::optim::Schedule).
//!
//! # The same bytes
//!
//! Order of the examples and dropout are functions of seed, epoch and step, so that there is no state of a generator to
//! save. A run that was stopped after any step and continued from its [checkpoint](Trainer::save) gives the same weights
//! as one that was not, bit for bit. On a CPU nothing here depends on the number of threads either; what a model's layers
//! do is theirs to promise. On a GPU sums may be ordered differently each time.

mod checkpoint;
mod config;
mod error;
mod order;
mod predict;
mod prefetch;
mod recipe;
mod trainer;

pub use config::TrainConfig;
pub use error::{Quantity, TrainError};
pub use predict::predict;
pub use recipe::{Regularize, Trainees};
pub use trainer::{StepReport, Trainer};
