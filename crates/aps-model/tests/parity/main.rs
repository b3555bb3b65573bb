//! The models against PyTorch's: `tests/golden/models.py` of the repository says what is compared and how it was made.
//!
//! The golden values were computed in double precision. Outputs, losses and gradients are compared in single precision, as
//! in use, and with the operations in use. Three steps are compared in double precision: in single precision Adam makes
//! full steps of gradients that are small by cancellation, and rounding moves weights by up to 1e-3 of their size, in
//! PyTorch as here.

mod adversarial;
mod golden;
mod optimizer;
mod outputs;
mod rule;
mod training;
