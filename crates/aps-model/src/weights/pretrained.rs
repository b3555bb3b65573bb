//! Which tensors of a model are a backbone, and what they are called in torchvision.

use std::collections::BTreeMap;

use super::names::Names;
use crate::Parameters;

/// Where the models keep their backbone: a ResNet, the regularizer's ResNet, a vision transformer.
const PLACES: [&str; 3] = ["encoder.", "cond_encoder.", "vit."];

/// What torchvision's `resnet18` and `vit_b_16` consist of, but for their classifiers.
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

/// The first layers of a multi-scale encoder, and what they are in a ResNet.
const STEM: [(&str, &str); 2] = [("stem.0.", "conv1."), ("stem.1.", "bn1.")];

/// The backbone of a model: its tensors by torchvision's names, or by their own where torchvision has none, as for the
/// projections of a multi-scale encoder.
#[derive(Debug)]
pub(super) struct Backbone(BTreeMap<String, String>);

impl Backbone {
    /// The backbone of the model; `None` if it has none.
    pub(super) fn of(parameters: &Parameters) -> Option<Self> {
        let all = parameters.all();
        let place = PLACES.iter().find(|place| {
            let has = |first| {
                all.iter()
                    .any(|(name, _)| *name == format!("{place}{first}"))
            };
            has("conv1.weight") || has("stem.0.weight") || has("conv_proj.weight")
        })?;
        let inside = |name: String| Some((spelled(name.strip_prefix(place)?), name));
        Some(Self(
            all.into_iter()
                .filter_map(|(name, _)| inside(name))
                .collect(),
        ))
    }

    /// The backbone's tensors among those of a file, of torchvision or of another model. Classifiers, decoders, and
    /// projections that this model does not have lie elsewhere.
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

    /// Whether the backbone is not one without the model's tensor `name`.
    pub(super) fn needs(&self, name: &str) -> bool {
        self.0
            .iter()
            .any(|(spelled, own)| own == name && is_torchvision_s(spelled))
    }
}

/// torchvision's name of a tensor of an encoder.
fn spelled(name: &str) -> String {
    let stem =
        |(ours, theirs): &(&str, &str)| Some(format!("{theirs}{}", name.strip_prefix(ours)?));
    STEM.iter()
        .find_map(stem)
        .unwrap_or_else(|| name.to_owned())
}

fn is_torchvision_s(spelled: &str) -> bool {
    let first = spelled.split('.').next();
    first.is_some_and(|first| PARTS.contains(&first))
}
