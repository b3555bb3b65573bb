//! Sizes of the models.

use candle_core::DType;
use candle_nn::VarMap;

use super::{blank, shape_of};
use crate::{ModelKind, Preset, trainable};

/// Compares the trainable parameters of each model and of its regularizer, without buffers.
#[track_caller]
fn assert_counts(preset: Preset, expected: [(&str, usize); 10]) {
    let count = |parameters: &VarMap| {
        let all = trainable(parameters).into_iter();
        all.map(|(_, var)| var.elem_count()).sum()
    };
    let mut counts = Vec::new();
    for kind in ModelKind::ALL {
        let (own, critic) = (VarMap::new(), VarMap::new());
        let builder = |parameters| blank(parameters, DType::F32);
        kind.build(preset, shape_of(kind), builder(&own)).unwrap();
        counts.push((kind.to_string(), count(&own)));
        let regularizer = kind.build_regularizer(preset, builder(&critic)).unwrap();
        if regularizer.is_some() {
            counts.push((format!("regularizer of {kind}"), count(&critic)));
        }
    }
    let counts: Vec<_> = counts.iter().map(|(name, n)| (name.as_str(), *n)).collect();
    assert_eq!(counts, expected, "{preset}");
}

#[test]
fn paper_s_models_have_the_paper_s_counts() {
    let expected = [
        ("ms_areg", 15_042_036),
        ("regularizer of ms_areg", 11_925_825),
        ("ms_mlp", 14_746_868),
        ("adv_mlp", 13_663_732),
        ("regularizer of adv_mlp", 11_925_825),
        ("resnet_mlp", 11_531_508),
        ("radiounet", 31_169_076),
        ("vit_reg", 86_284_724),
        ("resnet_conv1d", 18_853_377),
        ("polar_reg", 3_841),
    ];
    assert_counts(Preset::Paper, expected);
}

#[test]
fn small_models_have_the_documented_counts() {
    let expected = [
        ("ms_areg", 3_789_652),
        ("regularizer of ms_areg", 3_009_697),
        ("ms_mlp", 3_715_796),
        ("adv_mlp", 3_444_564),
        ("regularizer of adv_mlp", 3_009_697),
        ("resnet_mlp", 2_910_932),
        ("radiounet", 1_969_428),
        ("vit_reg", 2_791_092),
        ("resnet_conv1d", 4_721_921),
        ("polar_reg", 3_841),
    ];
    assert_counts(Preset::Small, expected);
}
