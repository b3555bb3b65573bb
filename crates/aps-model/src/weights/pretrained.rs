//! Which tensors of a model are a backbone, and what they are called in torchvision and in other models.

use crate::Parameters;

/// Where the models keep their ResNet.
const ENCODER: &str = "encoder.";

/// Whether a file with these names is of a model, not of torchvision.
pub(super) fn is_of_a_model<'a>(mut names: impl Iterator<Item = &'a str>) -> bool {
    names.any(|name| name.starts_with(ENCODER) || name.starts_with("vit."))
}

/// The backbone of a model, told by the names of its tensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Backbone {
    /// A ResNet below that prefix.
    ResNet(&'static str),
    /// A ResNet whose first layers are `stem.0` and `stem.1`, below that prefix.
    ResNetWithStem(&'static str),
    /// A vision transformer below that prefix.
    Vit(&'static str),
}

impl Backbone {
    pub(super) fn of(parameters: &Parameters) -> Option<Self> {
        let has = |name| parameters.get(name).is_some();
        if has("encoder.stem.0.weight") {
            Some(Self::ResNetWithStem("encoder."))
        } else if has("encoder.conv1.weight") {
            Some(Self::ResNet("encoder."))
        } else if has("cond_encoder.conv1.weight") {
            Some(Self::ResNet("cond_encoder."))
        } else if has("vit.conv_proj.weight") {
            Some(Self::Vit("vit."))
        } else {
            None
        }
    }

    /// The model's name of torchvision's tensor `name`; `None` for the classifier's.
    pub(super) fn rename(self, name: &str) -> Option<String> {
        let (prefix, classifier) = match self {
            Self::ResNet(prefix) | Self::ResNetWithStem(prefix) => (prefix, "fc."),
            Self::Vit(prefix) => (prefix, "heads."),
        };
        if name.starts_with(classifier) {
            return None;
        }
        let renamed = match self {
            Self::ResNetWithStem(_) => {
                ["conv1.", "bn1."]
                    .iter()
                    .enumerate()
                    .find_map(|(i, first)| {
                        name.strip_prefix(first)
                            .map(|rest| format!("{prefix}stem.{i}.{rest}"))
                    })
            }
            _ => None,
        };
        Some(renamed.unwrap_or_else(|| format!("{prefix}{name}")))
    }

    /// The model's name of the tensor `name` of another model's; `None` for what is not part of an encoder, or of another
    /// one: the projections of a multi-scale encoder, where this model has none.
    pub(super) fn adopt(self, name: &str) -> Option<String> {
        let (Self::ResNet(_) | Self::ResNetWithStem(_)) = self else {
            return name.starts_with("vit.").then(|| name.to_owned());
        };
        let inside = name.strip_prefix(ENCODER)?;
        match inside.split_once('.')? {
            ("stem", rest) => {
                let (at, rest) = rest.split_once('.')?;
                let first = ["conv1", "bn1"].get(at.parse::<usize>().ok()?)?;
                self.rename(&format!("{first}.{rest}"))
            }
            ("conv1" | "bn1" | "layer1" | "layer2" | "layer3" | "layer4", _) => self.rename(inside),
            _ => matches!(self, Self::ResNetWithStem(_)).then(|| name.to_owned()),
        }
    }

    /// Whether the model's tensor `name` belongs to it.
    pub(super) fn contains(self, name: &str) -> bool {
        match self {
            Self::ResNet(prefix) | Self::Vit(prefix) => name.starts_with(prefix),
            Self::ResNetWithStem(prefix) => name
                .strip_prefix(prefix)
                .is_some_and(|rest| rest.starts_with("stem.") || rest.starts_with("layer")),
        }
    }
}
