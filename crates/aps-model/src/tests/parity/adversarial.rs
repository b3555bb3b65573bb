//! Adversarial training, the regularizer's update and the predictor's: one step in single precision, three in double.

use candle_core::{DType, Result, Tensor};
use candle_nn::VarMap;

use super::super::blank;
use super::golden::Golden;
use super::optimizer::{Adam, gradients};
use super::rule::{images, set_weights, targets};
use super::training::{Tolerances, check_after, check_gradients, check_loss, scalar, tensors};
use crate::condition::InputShape;
use crate::{ModelKind, Preset};

/// Mean of max(z, 0) - z t + ln(1 + e^-|z|).
fn cross_entropy(logits: &Tensor, target: f64) -> Result<Tensor> {
    let soft = (logits.abs()?.neg()?.exp()? + 1.0)?.log()?;
    ((logits.relu()? - (logits * target)?)? + soft)?.mean_all()
}

fn training_is_pytorch_s(dtype: DType, kind: ModelKind) -> Result<()> {
    let (parameters, critic_parameters) = (VarMap::new(), VarMap::new());
    let vb = blank(&parameters, dtype);
    let model = kind.build(Preset::Paper, InputShape::Images, vb)?;
    let vb = blank(&critic_parameters, dtype);
    let critic = kind.build_regularizer(Preset::Paper, vb)?;
    let critic = critic.expect("it is adversarial");
    let score = |images: &Tensor, spectra: &Tensor| {
        let encoded = critic.encode(images, true)?;
        critic.score(&encoded, spectra)
    };
    set_weights(&parameters);
    set_weights(&critic_parameters);
    let (golden, tolerances) = (Golden::of(kind.name()), Tolerances::of(dtype));
    let (images, targets) = (images(64).to_dtype(dtype)?, targets().to_dtype(dtype)?);
    let adam = || Adam::new(2e-4, [0.5, 0.999], 0.0);
    let (mut optimizer, mut critic_optimizer) = (adam(), adam());
    for step in 0..tolerances.steps {
        let output = model.forward_t(&images, true)?;
        let real = cross_entropy(&score(&images, &targets)?, 1.0)?;
        let fake = cross_entropy(&score(&images, &output.detach())?, 0.0)?;
        let loss = (real + fake)?;
        let moves = gradients(&critic_parameters, &loss.backward()?);
        if step == 0 {
            golden.check_absolute("train_64", &output, tolerances.output);
            check_gradients(&golden.rows("critic_gradients", &moves), &tolerances);
        }
        let losses = golden.values("critic_losses");
        check_loss(&losses, step, scalar(&loss), &tolerances);
        critic_optimizer.step(&critic_parameters, &moves);

        let fooled = cross_entropy(&score(&images, &output)?, 1.0)?;
        let error = (&output - &targets)?.abs()?.mean_all()?;
        let loss = (fooled + (error * 100.0)?)?;
        let moves = gradients(&parameters, &loss.backward()?);
        if step == 0 {
            check_gradients(&golden.rows("gradients", &moves), &tolerances);
        }
        check_loss(&golden.values("losses"), step, scalar(&loss), &tolerances);
        optimizer.step(&parameters, &moves);
    }
    if tolerances.steps == 3 {
        check_after(&golden.rows("after", &tensors(&parameters)));
        check_after(&golden.rows("critic_after", &tensors(&critic_parameters)));
    }
    Ok(())
}

trainings! {
    training_is_pytorch_s:
    ms_areg(ModelKind::MsAreg), ignore = "long: trains";
    adv_mlp(ModelKind::AdvMlp), ignore = "long: trains";
}
