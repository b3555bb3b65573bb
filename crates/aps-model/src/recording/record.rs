//! Operations recorded as they are computed.

use std::cell::Cell;
use std::collections::HashMap;

use candle_core::{Result, Tensor, TensorId, bail};

use super::graph::{Graph, Value};

/// A graph, and which tensors of candle are in it.
pub(super) struct Recorder {
    graph: Graph,
    values: HashMap<TensorId, Value>,
    /// Tensors of the model by name; those that an operation uses become constants of the graph.
    parameters: HashMap<TensorId, (String, Tensor)>,
}

thread_local! {
    /// The recorder of this thread; none while an operation is computed, so that what it consists of is not recorded.
    static RECORDER: Cell<Option<Box<Recorder>>> = const { Cell::new(None) };
}

/// Computes an operation. While a graph is recorded, `nodes` also adds it there: from the values of `inputs` in the graph it makes
/// that of the result.
///
/// # Errors
/// Errors of `compute`; while a graph is recorded also an input that no recorded operation made.
pub(crate) fn recorded(
    inputs: &[&Tensor],
    nodes: impl FnOnce(&mut Graph, &[Value]) -> Value,
    compute: impl FnOnce() -> Result<Tensor>,
) -> Result<Tensor> {
    let Some(mut recorder) = RECORDER.take() else {
        return compute();
    };
    let result = compute();
    let added = result.and_then(|result| {
        let values = inputs.iter().map(|x| recorder.value(x));
        let values = values.collect::<Result<Vec<_>>>()?;
        let value = nodes(&mut recorder.graph, &values);
        recorder.values.insert(result.id(), value);
        Ok(result)
    });
    RECORDER.set(Some(recorder));
    added
}

/// Returns true while a graph is recorded on this thread.
pub(crate) fn is_recording() -> bool {
    let recorder = RECORDER.take();
    let is_recording = recorder.is_some();
    RECORDER.set(recorder);
    is_recording
}

/// Records `forward` of `input` as a graph whose input and output have the names `[input, output]`; `parameters` are the tensors that
/// it may use.
pub(crate) fn record(
    [input_name, output_name]: [&str; 2],
    input: &Tensor,
    parameters: HashMap<TensorId, (String, Tensor)>,
    forward: impl FnOnce(&Tensor) -> Result<Tensor>,
) -> Result<Graph> {
    let mut graph = Graph::default();
    let values = HashMap::from([(input.id(), graph.named(input_name))]);
    RECORDER.set(Some(Box::new(Recorder {
        graph,
        values,
        parameters,
    })));
    let output = forward(input);
    let mut recorder = RECORDER.take().expect("operations put it back");
    let output = recorder.value(&output?)?;
    recorder.graph.rename(output, output_name);
    Ok(recorder.graph)
}

impl Recorder {
    fn value(&mut self, tensor: &Tensor) -> Result<Value> {
        if let Some(&value) = self.values.get(&tensor.id()) {
            return Ok(value);
        }
        let Some((name, tensor)) = self.parameters.remove(&tensor.id()) else {
            let dims = tensor.dims();
            bail!("an operation that is not recorded made a tensor of shape {dims:?}");
        };
        let value = self.graph.tensor(name, &tensor)?;
        self.values.insert(tensor.id(), value);
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use candle_core::{DType, Device};

    use super::*;
    use crate::ops;

    fn one() -> Tensor {
        Tensor::ones((1, 2), DType::F32, &Device::Cpu).unwrap()
    }

    #[test]
    fn an_operation_that_is_not_seen_is_an_error_and_not_a_constant() {
        let forward = |x: &Tensor| ops::relu(&(x + 1.0)?);
        let found = record(["x", "y"], &one(), HashMap::new(), forward);
        assert!(found.unwrap_err().to_string().contains("not recorded"));
        let unseen = record(["x", "y"], &one(), HashMap::new(), |x| x + 1.0);
        assert!(unseen.unwrap_err().to_string().contains("not recorded"));
    }

    #[test]
    fn operations_within_an_operation_are_not_recorded() {
        let forward = |x: &Tensor| recorded(&[x], |g, v| g.node("Twice", v, []), || ops::add(x, x));
        let graph = record(["x", "y"], &one(), HashMap::new(), forward).unwrap();
        assert_eq!(graph.nodes.len(), 1);
        assert_eq!(graph.nodes[0].input, ["x"]);
        assert_eq!(graph.nodes[0].output, ["y"]);
        // Nothing is left behind.
        assert!(RECORDER.take().is_none());
    }
}
