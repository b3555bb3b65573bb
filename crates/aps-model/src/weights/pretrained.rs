//! Backbones of models: their tensors, and the names of these in torchvision.

use std::collections::BTreeMap;

use candle_core::Var;
use candle_nn::VarMap;

use super::names::Names;
use crate::parameters::sorted;

/// Prefixes of a model's backbone: a ResNet, the regularizer's ResNet, a vision transformer.
const PLACES: [&str; 3] = ["encoder.", "cond_encoder.", "vit."];

/// Parts of torchvision's `resnet18` and `vit_b_16`, but for their classifiers.
const PARTS: [&str; 9] = [
    "conv1",
    "bn1",
    "layer1",
    "layer2",
    "layer3",
    "layer4",
    "class_token",
    "conv_proj",
    "encoder",
];

/// Prefixes of the first layers: in a multi-scale encoder, and in a ResNet.
const STEM: [(&str, &str); 2] = [("stem.0.", "conv1."), ("stem.1.", "bn1.")];

/// The backbone of a model: its tensors by torchvision's names, or by their own where torchvision has none, as for the
/// projections of a multi-scale encoder.
#[derive(Debug)]
pub(super) struct Backbone(BTreeMap<String, String>);

impl Backbone {
    /// Finds the backbone of the model; `None` if it has none.
    pub(super) fn of(parameters: &VarMap) -> Option<Self> {
        let all = sorted(parameters);
        let place = PLACES.iter().find(|place| {
            let mut inside = all.iter().filter_map(|(name, _)| name.strip_prefix(*place));
            inside.any(|name| ["conv1.weight", "stem.0.weight", "conv_proj.weight"].contains(&name))
        })?;
        let inside = |(name, _): (String, Var)| Some((spelled(name.strip_prefix(place)?), name));
        Some(Self(all.into_iter().filter_map(inside).collect()))
    }

    /// Finds the backbone's tensors in a file of torchvision or of another model, by the file's names. Classifiers,
    /// decoders, and projections that this model does not have lie elsewhere.
    pub(super) fn among<'a>(
        &self,
        stored: impl Iterator<Item = &'a str> + Clone,
    ) -> Result<Names, String> {
        let own = |name: &str| self.0.get(&spelled(name)).cloned();
        let mut names = Names::of(stored, self.0.len(), own)?;
        let (unknown, others) = std::mem::take(&mut names.unknown)
            .into_iter()
            .partition(|(name, _)| is_torchvision_s(&spelled(name)));
        let others: BTreeMap<String, String> = others;
        names.unknown = unknown;
        names.elsewhere.extend(others.into_values());
        names.elsewhere.sort_unstable();
        Ok(names)
    }

    /// Returns true when the model's tensor `name` belongs to torchvision's backbone, so that no backbone lacks it.
    pub(super) fn needs(&self, name: &str) -> bool {
        let is_it = |(spelled, own): (&String, &String)| own == name && is_torchvision_s(spelled);
        self.0.iter().any(is_it)
    }
}

/// Returns torchvision's name of a tensor of an encoder.
fn spelled(name: &str) -> String {
    let mut stem = STEM.iter().filter_map(|(ours, theirs)| {
        let rest = name.strip_prefix(ours)?;
        Some(format!("{theirs}{rest}"))
    });
    stem.next().unwrap_or_else(|| name.to_owned())
}

fn is_torchvision_s(spelled: &str) -> bool {
    let first = spelled.split('.').next();
    first.is_some_and(|first| PARTS.contains(&first))
}
