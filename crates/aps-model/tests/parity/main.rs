//! The models against PyTorch's: `tests/golden/models.py` of the repository says what is compared and how it was made.
//!
//! The golden values were computed in double precision. Outputs, gradients and losses here are in single precision, as in
//! use.

mod adversarial;
mod golden;
mod optimizer;
mod outputs;
mod rule;
mod training;
