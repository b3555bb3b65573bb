//! Three adversarial steps: the regularizer's and the predictor's update.

use std::sync::Mutex;

use aps_model::candle_core::Tensor;
use aps_model::models::{AdvMlp, MsAreg, Regularizer};
use aps_model::{Mode, Model};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::golden::Golden;
use crate::optimizer::{Adam, gradients};
use crate::rule::{images, set_weights, targets};
use crate::training::{
    check_after, check_gradients, check_losses, fresh, tensors, without_gradient,
};

/// Mean of max(z, 0) - z t + ln(1 + e^-|z|).
fn cross_entropy(logits: &Tensor, target: f64) -> aps_model::Result<Tensor> {
    let soft = (logits.abs()?.neg()?.exp()? + 1.0)?.log()?;
    Ok(((logits.relu()? - (logits * target)?)? + soft)?.mean_all()?)
}

fn three_steps_are_pytorch_s(name: &str, model: &dyn Model) -> aps_model::Result<()> {
    let critic = Regularizer::new(&fresh(), 64)?;
    set_weights(model.parameters());
    set_weights(critic.parameters());
    let golden = Golden::of(name);
    let (images, targets) = (images(64), targets());
    let generator = Mutex::new(ChaCha8Rng::seed_from_u64(0));
    let train = Mode::Train(&generator);
    let adam = || Adam::new(2e-4, (0.5, 0.999), 0.0);
    let (mut optimizer, mut critic_optimizer) = (adam(), adam());
    let (mut losses, mut critic_losses) = (Vec::new(), Vec::new());
    let (mut lost, mut critic_lost) = (Vec::new(), Vec::new());
    for step in 0..3 {
        let output = model.forward(&images, train)?;
        let real = cross_entropy(&critic.forward(&images, &targets, train)?, 1.0)?;
        let fake = cross_entropy(&critic.forward(&images, &output.detach(), train)?, 0.0)?;
        let loss = (real + fake)?;
        let moves = gradients(critic.parameters(), &loss.backward()?);
        if step == 0 {
            golden.check_absolute("train_64", &output, 1e-4);
            let rows = golden.rows("critic_gradients", &moves);
            check_gradients(&rows);
            critic_lost = without_gradient(&rows);
        }
        critic_optimizer.step(critic.parameters(), &moves);
        critic_losses.push(f64::from(loss.to_scalar::<f32>()?));

        let fooled = cross_entropy(&critic.forward(&images, &output, train)?, 1.0)?;
        let error = (&output - &targets)?.abs()?.mean_all()?;
        let loss = (fooled + (error * 100.0)?)?;
        let moves = gradients(model.parameters(), &loss.backward()?);
        if step == 0 {
            let rows = golden.rows("gradients", &moves);
            check_gradients(&rows);
            lost = without_gradient(&rows);
        }
        optimizer.step(model.parameters(), &moves);
        losses.push(f64::from(loss.to_scalar::<f32>()?));
    }
    check_losses(&golden.values("losses"), &losses);
    check_losses(&golden.values("critic_losses"), &critic_losses);
    check_after(
        &golden.rows("after", &tensors(model.parameters())),
        &lost,
        2e-4,
    );
    check_after(
        &golden.rows("critic_after", &tensors(critic.parameters())),
        &critic_lost,
        2e-4,
    );
    Ok(())
}

#[test]
fn adversarial_training_of_ms_areg() {
    three_steps_are_pytorch_s("ms_areg", &MsAreg::new(&fresh(), 64).unwrap()).unwrap();
}

#[test]
fn adversarial_training_of_adv_mlp() {
    three_steps_are_pytorch_s("adv_mlp", &AdvMlp::new(&fresh(), 64).unwrap()).unwrap();
}
