//! The models against PyTorch's: `tests/golden/models.py` of the repository says what is compared and how it was made.
//!
//! The golden values were computed in double precision. Outputs, losses and gradients are compared in single precision, as
//! in use, and with the operations in use. Three steps are compared in double precision: in single precision Adam makes
//! full steps of gradients that are small by cancellation. PyTorch's own f32 run ends up to 4e-2 of a tensor's largest value
//! from its f64 run, and up to 2e-3 in a tensor's norm (ResNet-MLP, MS-MLP, ResNet-Conv1D).

/// Tests of a training for each model: one step in single precision, three in double.
macro_rules! trainings {
    ($check:ident: $($model:ident($($argument:expr),+) $(, $long:meta)?;)*) => {
        mod one_step {
            use super::*;
            $(#[test]
            fn $model() {
                $check(DType::F32, $($argument),+).unwrap();
            })*
        }

        mod three_steps {
            use super::*;
            $(#[test]
            $(#[$long])?
            fn $model() {
                $check(DType::F64, $($argument),+).unwrap();
            })*
        }
    };
}

mod adversarial;
mod golden;
mod optimizer;
mod outputs;
mod polar;
mod rule;
mod training;
