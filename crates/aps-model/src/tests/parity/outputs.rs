//! Outputs in evaluation mode.

use candle_core::DType;
use candle_nn::VarMap;

use super::super::blank;
use super::golden::Golden;
use super::rule::{images, set_weights, targets};
use crate::condition::{InputKind, InputShape};
use crate::{ModelKind, Preset};

fn outputs_are_pytorch_s(size: usize) {
    let of_images = |kind: &ModelKind| kind.input() == InputKind::Images;
    for kind in ModelKind::ALL.into_iter().filter(of_images) {
        let parameters = VarMap::new();
        let vb = blank(&parameters, DType::F32);
        let model = kind.build(Preset::Paper, InputShape::Images, vb).unwrap();
        set_weights(&parameters);
        let found = model.forward_t(&images(size), false).unwrap();
        Golden::of(kind.name()).check_absolute(&format!("eval_{size}"), &found, 1e-4);
    }
}

#[test]
fn outputs_at_64_px() {
    outputs_are_pytorch_s(64);
}

#[test]
#[ignore = "long: images of the paper's size"]
fn outputs_at_256_px() {
    outputs_are_pytorch_s(256);
}

#[test]
fn scores_of_the_regularizer() {
    let parameters = VarMap::new();
    let vb = blank(&parameters, DType::F32);
    let built = ModelKind::MsAreg.build_regularizer(Preset::Paper, vb);
    let regularizer = built.unwrap().unwrap();
    set_weights(&parameters);
    let encoded = regularizer.encode(&images(64), false).unwrap();
    let found = regularizer.score(&encoded, &targets()).unwrap();
    Golden::of("ms_areg").check_absolute("critic_eval_64", &found, 1e-4);
}
