//! Adversarial training, the regularizer's update and the predictor's: one step in single precision, three in double.

use std::sync::Mutex;

use aps_model::candle_core::{DType, Tensor};
use aps_model::models::{AdvMlp, MsAreg, Regularizer};
use aps_model::{Mode, Model, Parameters, Result};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::golden::Golden;
use crate::optimizer::{Adam, gradients};
use crate::rule::{images, set_weights, targets};
use crate::training::{Rigour, check_after, check_gradients, check_loss, fresh, scalar, tensors};

/// Mean of max(z, 0) - z t + ln(1 + e^-|z|).
fn cross_entropy(logits: &Tensor, target: f64) -> Result<Tensor> {
    let soft = (logits.abs()?.neg()?.exp()? + 1.0)?.log()?;
    Ok(((logits.relu()? - (logits * target)?)? + soft)?.mean_all()?)
}

fn training_is_pytorch_s(
    dtype: DType,
    name: &str,
    build: impl Fn(&Parameters) -> Result<Box<dyn Model>>,
) -> Result<()> {
    let (parameters, critic_parameters) = (fresh(dtype), fresh(dtype));
    let model = build(&parameters)?;
    let critic = Regularizer::new(&critic_parameters, 64)?;
    set_weights(&parameters);
    set_weights(&critic_parameters);
    let (golden, rigour) = (Golden::of(name), Rigour::of(dtype));
    let (images, targets) = (images(64).to_dtype(dtype)?, targets().to_dtype(dtype)?);
    let generator = Mutex::new(ChaCha8Rng::seed_from_u64(0));
    let train = Mode::Train(&generator);
    let adam = || Adam::new(2e-4, [0.5, 0.999], 0.0);
    let (mut optimizer, mut critic_optimizer) = (adam(), adam());
    for step in 0..rigour.steps {
        let output = model.forward(&images, train)?;
        let real = cross_entropy(&critic.forward(&images, &targets, train)?, 1.0)?;
        let fake = cross_entropy(&critic.forward(&images, &output.detach(), train)?, 0.0)?;
        let loss = (real + fake)?;
        let moves = gradients(&critic_parameters, &loss.backward()?);
        if step == 0 {
            golden.check_absolute("train_64", &output, rigour.output);
            check_gradients(&golden.rows("critic_gradients", &moves), &rigour);
        }
        check_loss(
            &golden.values("critic_losses"),
            step,
            scalar(&loss),
            &rigour,
        );
        critic_optimizer.step(&critic_parameters, &moves);

        let fooled = cross_entropy(&critic.forward(&images, &output, train)?, 1.0)?;
        let error = (&output - &targets)?.abs()?.mean_all()?;
        let loss = (fooled + (error * 100.0)?)?;
        let moves = gradients(&parameters, &loss.backward()?);
        if step == 0 {
            check_gradients(&golden.rows("gradients", &moves), &rigour);
        }
        check_loss(&golden.values("losses"), step, scalar(&loss), &rigour);
        optimizer.step(&parameters, &moves);
    }
    if rigour.steps == 3 {
        check_after(&golden.rows("after", &tensors(&parameters)));
        check_after(&golden.rows("critic_after", &tensors(&critic_parameters)));
    }
    Ok(())
}

fn ms_areg(parameters: &Parameters) -> Result<Box<dyn Model>> {
    Ok(Box::new(MsAreg::new(parameters, 64)?))
}

fn adv_mlp(parameters: &Parameters) -> Result<Box<dyn Model>> {
    Ok(Box::new(AdvMlp::new(parameters, 64)?))
}

#[test]
fn adversarial_gradients_of_ms_areg() {
    training_is_pytorch_s(DType::F32, "ms_areg", ms_areg).unwrap();
}

#[test]
fn adversarial_three_steps_of_ms_areg() {
    training_is_pytorch_s(DType::F64, "ms_areg", ms_areg).unwrap();
}

#[test]
fn adversarial_gradients_of_adv_mlp() {
    training_is_pytorch_s(DType::F32, "adv_mlp", adv_mlp).unwrap();
}

#[test]
fn adversarial_three_steps_of_adv_mlp() {
    training_is_pytorch_s(DType::F64, "adv_mlp", adv_mlp).unwrap();
}
