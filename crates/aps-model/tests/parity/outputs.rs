//! Outputs in evaluation mode.

use aps_model::candle_core::{DType, Device};
use aps_model::{Mode, ModelKind, Parameters, Preset};

use crate::golden::Golden;
use crate::rule::{images, set_weights, targets};

fn outputs_are_pytorch_s(kind: ModelKind, name: &str, size: usize) {
    let parameters = Parameters::new(&Device::Cpu, DType::F32, 0);
    let model = kind.build(Preset::Paper, &parameters).unwrap();
    set_weights(&parameters);
    let golden = Golden::of(kind.name());
    let found = model.forward(&images(size), Mode::Eval).unwrap();
    golden.check_absolute(name, &found, 1e-4);
}

#[test]
fn outputs_of_ms_areg() {
    outputs_are_pytorch_s(ModelKind::MsAreg, "eval_64", 64);
}

#[test]
fn outputs_of_ms_mlp() {
    outputs_are_pytorch_s(ModelKind::MsMlp, "eval_64", 64);
}

#[test]
fn outputs_of_adv_mlp() {
    outputs_are_pytorch_s(ModelKind::AdvMlp, "eval_64", 64);
}

#[test]
fn outputs_of_resnet_mlp() {
    outputs_are_pytorch_s(ModelKind::ResnetMlp, "eval_64", 64);
}

#[test]
fn outputs_of_radiounet() {
    outputs_are_pytorch_s(ModelKind::RadioUnet, "eval_64", 64);
}

#[test]
fn outputs_of_vit_reg() {
    outputs_are_pytorch_s(ModelKind::VitReg, "eval_64", 64);
}

#[test]
fn outputs_of_resnet_conv1d() {
    outputs_are_pytorch_s(ModelKind::ResnetConv1d, "eval_64", 64);
}

#[test]
#[ignore = "long: images of the paper's size"]
fn outputs_at_256_px() {
    for kind in ModelKind::ALL {
        outputs_are_pytorch_s(kind, "eval_256", 256);
    }
}

#[test]
fn scores_of_the_regularizer() {
    let parameters = Parameters::new(&Device::Cpu, DType::F32, 0);
    let regularizer = ModelKind::MsAreg
        .build_regularizer(Preset::Paper, &parameters)
        .unwrap()
        .unwrap();
    set_weights(&parameters);
    let found = regularizer
        .forward(&images(64), &targets(), Mode::Eval)
        .unwrap();
    Golden::of("ms_areg").check_absolute("critic_eval_64", &found, 1e-4);
}
