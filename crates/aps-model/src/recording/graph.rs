//! A graph of ONNX under construction.

use candle_core::{Result, Tensor};

use super::schema::{AttributeProto as Attribute, FLOAT, INT64, NodeProto, TensorProto};

/// A tensor in a graph: an input, a constant or a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Value(usize);

/// Nodes and constants so far.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    names: Vec<String>,
    pub nodes: Vec<NodeProto>,
    pub constants: Vec<TensorProto>,
}

impl Graph {
    /// Adds a value of a name that no other has.
    pub(super) fn named(&mut self, name: impl Into<String>) -> Value {
        self.names.push(name.into());
        Value(self.names.len() - 1)
    }

    /// Names the result of a node.
    pub(super) fn rename(&mut self, value: Value, name: &str) {
        let old = std::mem::replace(&mut self.names[value.0], name.to_owned());
        for node in &mut self.nodes {
            let all = node.input.iter_mut().chain(&mut node.output);
            all.filter(|found| **found == old)
                .for_each(|found| name.clone_into(found));
        }
    }

    /// Adds an operation with one result.
    pub fn node(
        &mut self,
        operation: &str,
        inputs: &[Value],
        attributes: impl IntoIterator<Item = Attribute>,
    ) -> Value {
        let name = format!("{operation}_{}", self.nodes.len());
        let output = self.named(name.clone());
        self.nodes.push(NodeProto {
            input: inputs.iter().map(|v| self.names[v.0].clone()).collect(),
            output: vec![name.clone()],
            name,
            op_type: operation.to_owned(),
            attribute: attributes.into_iter().collect(),
        });
        output
    }

    /// Adds the values of a tensor in single precision, under a name that no other value has.
    pub(super) fn tensor(&mut self, name: String, tensor: &Tensor) -> Result<Value> {
        let values = tensor.flatten_all()?.to_vec1::<f32>()?;
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        Ok(self.constant(name, tensor.dims(), FLOAT, bytes))
    }

    /// Adds a constant of single precision.
    pub fn numbers(&mut self, dims: &[usize], values: &[f64]) -> Value {
        let bytes = values.iter().flat_map(|&x| (x as f32).to_le_bytes());
        self.constant(self.unnamed(), dims, FLOAT, bytes.collect())
    }

    /// Adds a single number.
    pub fn number(&mut self, value: f64) -> Value {
        self.numbers(&[], &[value])
    }

    /// Adds a list of whole numbers: a shape, or dimensions.
    pub fn whole(&mut self, values: &[i64]) -> Value {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.constant(self.unnamed(), &[values.len()], INT64, bytes)
    }

    /// Stands for an input that an operation does not get.
    pub fn none(&mut self) -> Value {
        self.named("")
    }

    fn unnamed(&self) -> String {
        format!("constant_{}", self.constants.len())
    }

    fn constant(&mut self, name: String, dims: &[usize], data_type: i32, bytes: Vec<u8>) -> Value {
        self.constants.push(TensorProto {
            dims: sizes(dims),
            data_type,
            name: name.clone(),
            raw_data: bytes,
        });
        self.named(name)
    }

    /// Gives a value other dimensions behind its first, which stays.
    pub fn reshape(&mut self, x: Value, rest: &[usize]) -> Value {
        // 0 stands for the dimension that is there.
        self.shaped(x, 0, rest)
    }

    /// Gives a value other dimensions, of which the first is as long as its values are enough for.
    pub fn regroup(&mut self, x: Value, rest: &[usize]) -> Value {
        self.shaped(x, -1, rest)
    }

    fn shaped(&mut self, x: Value, first: i64, rest: &[usize]) -> Value {
        let shape = self.whole(&[&[first], &sizes(rest)[..]].concat());
        self.node("Reshape", &[x, shape], [])
    }

    /// Takes elements start to end of a dimension.
    pub fn slice(&mut self, x: Value, dim: usize, [start, end]: [usize; 2]) -> Value {
        let [start, end, dim] = [start, end, dim].map(|n| self.whole(&[n as i64]));
        self.node("Slice", &[x, start, end, dim], [])
    }

    /// Repeats a value (1, rest ...) as often as `like` has elements of its first dimension.
    pub fn repeat(&mut self, x: Value, rest: &[usize], like: Value) -> Value {
        let count = self.node("Shape", &[like], [int("start", 0), int("end", 1)]);
        let rest = self.whole(&sizes(rest));
        let shape = self.node("Concat", &[count, rest], [int("axis", 0)]);
        self.node("Expand", &[x, shape], [])
    }
}

fn sizes(dims: &[usize]) -> Vec<i64> {
    dims.iter().map(|&d| d as i64).collect()
}

/// A setting that is a whole number.
pub(crate) fn int(name: &str, value: i64) -> Attribute {
    Attribute {
        i: Some(value),
        ..attribute(name, 2)
    }
}

/// A setting that is a number.
pub(crate) fn float(name: &str, value: f64) -> Attribute {
    Attribute {
        f: Some(value as f32),
        ..attribute(name, 1)
    }
}

/// A setting that is a word.
pub(crate) fn word(name: &str, value: &str) -> Attribute {
    Attribute {
        s: Some(value.into()),
        ..attribute(name, 3)
    }
}

/// A setting that is a list of whole numbers.
pub(crate) fn ints(name: &str, values: impl IntoIterator<Item = i64>) -> Attribute {
    Attribute {
        ints: values.into_iter().collect(),
        ..attribute(name, 7)
    }
}

fn attribute(name: &str, kind: i32) -> Attribute {
    Attribute {
        name: name.into(),
        kind,
        ..Attribute::default()
    }
}
