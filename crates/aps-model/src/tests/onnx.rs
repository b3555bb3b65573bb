//! Exported files, read back. Their values are compared with ONNX Runtime's by `tests/python/long/test_onnx.py`.

use std::collections::{HashMap, HashSet};

use candle_core::DType;
use candle_nn::VarMap;
use prost::Message;

use super::{builder, flat, shape_of};
use crate::condition::{InputKind, InputShape};
use crate::onnx::export;
use crate::parameters::{is_counter, sorted};
use crate::recording::schema::{Dimension, FLOAT, ModelProto, TensorProto, ValueInfoProto};
use crate::weights::Label;
use crate::{ModelKind, Preset};

const SIZE: usize = 64;

fn exported(kind: ModelKind, parameters: &VarMap) -> Vec<u8> {
    let (preset, shape) = (Preset::Small, shape_of(kind));
    let vb = builder(parameters, DType::F32, 1);
    kind.build(preset, shape, vb).unwrap();
    let facts = [("image_size", SIZE.to_string())];
    export(Label { kind, preset }, shape, SIZE, parameters, &facts).unwrap()
}

fn shape(value: &ValueInfoProto) -> Vec<String> {
    let of = value.r#type.clone().unwrap().tensor_type.unwrap();
    assert_eq!(of.elem_type, FLOAT);
    let dims = of.shape.unwrap().dim.into_iter();
    dims.map(|dim| match dim.value.unwrap() {
        Dimension::Value(size) => size.to_string(),
        Dimension::Parameter(name) => name,
    })
    .collect()
}

fn numbers(tensor: &TensorProto) -> Vec<f64> {
    let numbers = tensor.raw_data.as_chunks().0.iter();
    numbers
        .map(|&bytes| f32::from_le_bytes(bytes).into())
        .collect()
}

#[test]
fn parameters_of_another_model_are_refused() {
    let (kind, preset, shape) = (ModelKind::MsMlp, Preset::Small, InputShape::Images);
    let parameters = VarMap::new();
    let vb = builder(&parameters, DType::F32, 1);
    kind.build(preset, shape, vb).unwrap();
    // Of the same encoder, but with another decoder.
    let kind = ModelKind::ResnetConv1d;
    for parameters in [parameters, VarMap::new()] {
        let before = sorted(&parameters).len();
        let refused = export(Label { kind, preset }, shape, SIZE, &parameters, &[]);
        assert!(refused.is_err());
        assert_eq!(sorted(&parameters).len(), before);
    }
}

#[test]
fn a_file_tells_its_model_and_takes_any_number_of_links() {
    for kind in ModelKind::ALL {
        let file = exported(kind, &VarMap::new());
        let model = ModelProto::decode(&file[..]).unwrap();
        let facts = model.metadata_props.iter();
        let facts: Vec<_> = facts.map(|fact| (&*fact.key, &*fact.value)).collect();
        let of_ways = [("directions", "720"), ("kinds", "15")];
        let of_ways = &of_ways[..if kind == ModelKind::PolarReg { 2 } else { 0 }];
        let own = [("model", kind.name()), ("preset", "small")];
        let expected = [&own, of_ways, &[("image_size", "64")]].concat();
        assert_eq!(facts, expected);
        let graph = model.graph.unwrap();
        let ([input], [output]) = (&graph.input[..], &graph.output[..]) else {
            panic!("{kind}: one input, one output");
        };
        let (name, dims) = match kind.input() {
            InputKind::Images => ("condition", &["batch", "3", "64", "64"][..]),
            InputKind::Polar => ("ways", &["batch", "ways", "16"][..]),
        };
        assert_eq!((&*input.name, &*output.name), (name, "spectrum"));
        assert_eq!(shape(input), dims);
        assert_eq!(shape(output), ["batch", "180"]);
    }
}

#[test]
fn a_graph_has_the_weights_bit_for_bit_and_finds_every_input_made() {
    for kind in ModelKind::ALL {
        let parameters = VarMap::new();
        let model = ModelProto::decode(&exported(kind, &parameters)[..]).unwrap();
        let graph = model.graph.unwrap();
        let constants: HashMap<_, _> = graph.initializer.iter().map(|t| (&*t.name, t)).collect();
        let count = graph.initializer.len();
        assert_eq!(constants.len(), count, "{kind}: names are unique");
        for (name, var) in sorted(&parameters) {
            // Neither counts in evaluation: passes of training, and a choice that decided which graph was made.
            if is_counter(&var) || name == "fixed.is_by_link" {
                continue;
            }
            let found = constants[&*name];
            let dims: Vec<_> = found.dims.iter().map(|&d| d as usize).collect();
            assert_eq!(dims, var.dims(), "{kind}: {name}");
            assert_eq!(numbers(found), flat(&var), "{kind}: {name}");
        }
        // The empty name stands for an input that is not given.
        let given = ["", "condition", "ways"];
        let mut made: HashSet<&str> = constants.keys().copied().chain(given).collect();
        let mut used = HashSet::new();
        for node in &graph.node {
            let name = &node.name;
            for input in &node.input {
                assert!(made.contains(&**input), "{kind}: {input} of {name}");
                used.insert(&**input);
            }
            assert!(made.insert(&node.output[0]), "{kind}: {name} is made twice");
            // ONNX keeps the dimension unless told, candle's plain reductions drop it: each node says which.
            let says = node.attribute.iter().any(|a| a.name == "keepdims");
            assert!(
                !node.op_type.starts_with("Reduce") || says,
                "{kind}: {name}"
            );
        }
        assert!(made.contains("spectrum"), "{kind}");
        let is_used = |name: &&str| used.contains(name);
        assert!(
            constants.keys().all(is_used),
            "{kind}: every constant is used"
        );
    }
}

#[test]
fn the_same_weights_give_the_same_bytes() {
    for kind in [ModelKind::VitReg, ModelKind::PolarReg] {
        let [first, second] = [(); 2].map(|()| exported(kind, &VarMap::new()));
        assert!(first == second, "{kind}");
    }
}

#[test]
fn sizes_that_a_model_does_not_take_are_refused() {
    let (kind, preset, parameters) = (ModelKind::RadioUnet, Preset::Small, VarMap::new());
    let label = Label { kind, preset };
    let vb = builder(&parameters, DType::F32, 1);
    kind.build(preset, InputShape::Images, vb).unwrap();
    for (shape, size, told) in [
        (InputShape::Images, 40, "multiple of 16"),
        (InputShape::Images, 0, "must be 1 to 4096"),
        (InputShape::Images, usize::MAX, "must be 1 to 4096"),
        (shape_of(ModelKind::PolarReg), 64, "takes Images"),
    ] {
        let refused = export(label, shape, size, &parameters, &[]).unwrap_err();
        assert!(refused.to_string().contains(told), "{refused}");
    }
}
