//! Models as files of ONNX, for other runtimes.
//!
//! No model is described here: [`export`] evaluates it once, and each operation of its layers, as it is computed, adds the nodes
//! of the graph that stand beside it. Files have operators of version 17, and tensors under the names that files of weights have.

use candle_core::{DType, Device, Tensor};
use candle_nn::VarMap;
use prost::Message;

use crate::condition::{InputShape, MAX_SIZE};
use crate::parameters::sorted;
use crate::recording::record;
use crate::recording::schema::{
    Dimension, DimensionProto, FLOAT, GraphProto, IR_VERSION, ModelProto, OPERATORS,
    OperatorSetIdProto, StringStringEntryProto, TensorShapeProto, TensorTypeProto, TypeProto,
    ValueInfoProto,
};
use crate::weights::Label;
use crate::{ANGLE_BINS, Error, Result, frozen, seeded};

/// Name of the dimension of links.
const BATCH: &str = "batch";

/// Name of the output.
const SPECTRUM: &str = "spectrum";

/// Makes a file of ONNX of a model in evaluation, with the weights in `parameters`, which are on a CPU in single precision.
///
/// Its input is `condition` (batch, 3, `image_size`, `image_size`), or for ways along rays `ways` (batch, ways, numbers), any number of
/// ways from 1, where `image_size` is of no use; its output is `spectrum` (batch, [`ANGLE_BINS`]). Each tells its shape and units. `batch` is any
/// number from 1. `facts` go with model, preset and the numbers of directions and kinds of ways into the metadata, in their order. The same arguments give the same bytes.
///
/// # Errors
/// [`Error::Condition`] for images of no pixels or more than 4096 a side; [`Error::Candle`] for a shape or an image size that the model does
/// not take, and for parameters of another model.
///
/// ```
/// use aps_model::candle_core::{DType, Device};
/// use aps_model::candle_nn::VarMap;
/// use aps_model::condition::InputShape;
/// use aps_model::weights::Label;
/// use aps_model::{ModelKind, Preset, onnx, seeded};
///
/// let (kind, preset, parameters) = (ModelKind::MsMlp, Preset::Small, VarMap::new());
/// kind.build(preset, InputShape::Images, seeded(&parameters, 1, DType::F32, &Device::Cpu))?;
/// let file = onnx::export(Label { kind, preset }, InputShape::Images, 64, &parameters, &[])?;
/// std::fs::write(std::env::temp_dir().join("ms_mlp.onnx"), file)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn export(
    label: Label,
    shape: InputShape,
    image_size: usize,
    parameters: &VarMap,
    facts: &[(&str, String)],
) -> Result<Vec<u8>> {
    if shape == InputShape::Images && !(1..=MAX_SIZE).contains(&image_size) {
        let text = format!("image size {image_size}: must be 1 to {MAX_SIZE}");
        return Err(Error::Condition(text));
    }
    // Refuses parameters of another model, where the builder below would add its own.
    label.kind.build(label.preset, shape, frozen(parameters)?)?;
    // Of variables, whose layers compute with the tensors themselves: those of constants take copies.
    let vb = seeded(parameters, 0, DType::F32, &Device::Cpu);
    let model = label.kind.build(label.preset, shape, vb)?;
    let (name, dims, told) = input(shape, image_size);
    let length = |dim: &Dimension| match dim {
        Dimension::Value(length) => *length as usize,
        Dimension::Parameter(_) => 1,
    };
    let one: Vec<usize> = dims.iter().map(length).collect();
    let one = Tensor::zeros(one, DType::F32, &Device::Cpu)?;
    let known = sorted(parameters).into_iter();
    let known = known.map(|(name, var)| (var.id(), (name, var.as_tensor().clone())));
    let known = known.collect();
    let graph = record([name, SPECTRUM], &one, known, |x| model.forward_t(x, false))?;

    let (kind, preset) = (label.kind, label.preset);
    let mut metadata = vec![("model", kind.to_string()), ("preset", preset.to_string())];
    if let InputShape::Polar(shape) = shape {
        metadata.push(("directions", shape.directions.to_string()));
        metadata.push(("kinds", shape.kinds.to_string()));
    }
    metadata.extend_from_slice(facts);
    let fact = |(key, value): (&str, String)| StringStringEntryProto {
        key: key.into(),
        value,
    };
    let file = ModelProto {
        ir_version: IR_VERSION,
        producer_name: "map2aps".into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        doc_string: format!(
            "{}, preset {preset}: angle power spectra of links",
            kind.title()
        ),
        graph: Some(GraphProto {
            node: graph.nodes,
            name: kind.name().into(),
            initializer: graph.constants,
            input: vec![tensor(name, dims, told)],
            output: vec![tensor(
                SPECTRUM,
                [any(BATCH), fixed(ANGLE_BINS)],
                OUTPUT.into(),
            )],
        }),
        opset_import: vec![OperatorSetIdProto {
            domain: Some(String::new()),
            version: OPERATORS,
        }],
        metadata_props: metadata.into_iter().map(fact).collect(),
    };
    Ok(file.encode_to_vec())
}

const OUTPUT: &str = "(batch, bin): power relative to the largest of the link, a linear ratio, normalised as the \
                      labels of the protocol are; no unit. Bins are those of the labels, the first at -180 degrees.";

/// A dimension of a length.
fn fixed(length: usize) -> Dimension {
    Dimension::Value(length as i64)
}

/// A dimension of any length.
fn any(name: &str) -> Dimension {
    Dimension::Parameter(name.into())
}

/// Name, dimensions and description of an input.
fn input(shape: InputShape, image_size: usize) -> (&'static str, Vec<Dimension>, String) {
    match shape {
        InputShape::Images => (
            "condition",
            vec![any(BATCH), fixed(3), fixed(image_size), fixed(image_size)],
            "(batch, channel, row, column), rows along y, columns along x, no unit. Channel 0: share of the pixel that is built \
             upon, 0 to 1; 1: Gaussian spot at the transmitter, 1 in its middle; 2: the same at the receiver."
                .into(),
        ),
        InputShape::Polar(shape) => (
            "ways",
            vec![any(BATCH), any("ways"), fixed(shape.per_way())],
            format!(
                "(batch, way, number), no unit: ways that arrive along {} rays around the receiver; {} features, number of the ray, \
                 and number of the kind, of {} kinds. Feature 1 is 1; links of fewer ways end with ways of zeros.",
                shape.directions, shape.features, shape.kinds
            ),
        ),
    }
}

/// Describes a tensor.
fn tensor(
    name: &str,
    dims: impl IntoIterator<Item = Dimension>,
    doc_string: String,
) -> ValueInfoProto {
    let dim = |value| DimensionProto { value: Some(value) };
    let shape = TensorShapeProto {
        dim: dims.into_iter().map(dim).collect(),
    };
    ValueInfoProto {
        name: name.into(),
        r#type: Some(TypeProto {
            tensor_type: Some(TensorTypeProto {
                elem_type: FLOAT,
                shape: Some(shape),
            }),
        }),
        doc_string,
    }
}
