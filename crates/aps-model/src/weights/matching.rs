//! Tensors of a file to tensors of a model.

use std::collections::HashSet;

use candle_core::{D, DType, Tensor, Var};

use super::names::{Names, listed};
use super::report::LoadReport;
use super::source::Source;
use crate::parameters::{is_counter, is_variance};
use crate::{Error, Result};

/// Inputs that a matrix of the file lacks: its last columns, which are filled with zeros.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    /// The model's name of the matrix.
    pub of: &'static str,
    pub count: usize,
}

/// Fills each of `wanted` from the file. A tensor that the model does not know is an error; tensors elsewhere are left out.
///
/// Nothing is changed unless all fit.
pub(super) fn assign(
    source: &Source,
    names: Names,
    wanted: &[(String, Var)],
    lacking: Option<Columns>,
) -> Result<LoadReport> {
    let mut report = LoadReport::default();
    let mut problems = Vec::new();
    let mut values = Vec::new();
    for (name, var) in wanted {
        let mut expected = var.dims().to_vec();
        let zeros = lacking.filter(|columns| columns.of == name);
        if let (Some(zeros), Some(inputs)) = (zeros, expected.last_mut()) {
            *inputs = inputs.saturating_sub(zeros.count);
        }
        let Some(stored) = names.found.get(name) else {
            if is_counter(var) {
                report.zeroed.push(name.clone());
                values.push((var, var.zeros_like()?));
            } else {
                problems.push(format!("{name} {expected:?} is missing"));
            }
            continue;
        };
        let (shape, dtype) = source.shape(stored);
        if shape != expected {
            problems.push(format!("{name} has the shape {shape:?}, not {expected:?}"));
        } else if dtype.is_int() != is_counter(var) {
            let wanted = if is_counter(var) {
                "whole numbers"
            } else {
                "real numbers"
            };
            problems.push(format!("{name} has the type {dtype:?}, not of {wanted}"));
        } else if problems.is_empty() {
            let tensor = source.tensor(stored)?;
            if !is_counter(var) && !is_finite(&tensor)? {
                problems.push(format!("{name} holds values that are not finite"));
            } else if is_variance(name) && !has_no_sign(&tensor)? {
                problems.push(format!("{name} holds a variance below 0"));
            }
            let tensor = match zeros {
                Some(zeros) => tensor.pad_with_zeros(D::Minus1, 0, zeros.count)?,
                None => tensor,
            };
            values.push((var, tensor));
        }
    }
    if !problems.is_empty() || !names.unknown.is_empty() {
        return Err(Error::WeightsMismatch {
            path: source.path().to_owned(),
            problems: explain(problems, &names, source.others()),
        });
    }
    for (var, tensor) in &values {
        var.set(&tensor.to_dtype(var.dtype())?.to_device(var.device())?)?;
    }
    report.loaded = values.len() - report.zeroed.len();
    report.dropped = names.elsewhere;
    Ok(report)
}

/// Tensors of the file, meant for the model's of the same name.
pub(super) fn own_names(source: &Source, wanted: &[(String, Var)]) -> Result<Names> {
    let wanted: HashSet<&str> = wanted.iter().map(|(name, _)| name.as_str()).collect();
    let own = |name: &str| wanted.contains(name).then(|| name.to_owned());
    let names = Names::of(source.names(), wanted.len(), own);
    names.map_err(|e| Error::weights_format(source.path(), e))
}

/// Lists why tensors of the model and of the file do not fit, at most so many of each, and the other entries of the file.
fn explain(mut problems: Vec<String>, names: &Names, others: &[String]) -> Vec<String> {
    const SHOWN: usize = 24;
    let shorten = |lines: &mut Vec<String>, what: &str| {
        if let more @ 1.. = lines.len().saturating_sub(SHOWN) {
            lines.truncate(SHOWN);
            lines.push(format!("and {more} more {what}"));
        }
    };
    shorten(&mut problems, "of the model's tensors");
    let unknown = names
        .unknown
        .values()
        .map(|name| format!("{name} is not part of the model"));
    let mut unknown = unknown.collect();
    shorten(&mut unknown, "of the file's tensors");
    problems.append(&mut unknown);
    if !names.elsewhere.is_empty() {
        let text = listed(&names.elsewhere);
        problems.push(format!("the file holds besides: {text}"));
    }
    if !others.is_empty() {
        let text = listed(others);
        problems.push(format!(
            "the file holds entries that are no tensors: {text}"
        ));
    }
    problems
}

pub(crate) fn is_finite(tensor: &Tensor) -> Result<bool> {
    Ok(values(tensor)?.iter().all(|v| v.is_finite()))
}

pub(crate) fn has_no_sign(tensor: &Tensor) -> Result<bool> {
    Ok(values(tensor)?.iter().all(|&v| v >= 0.0))
}

fn values(tensor: &Tensor) -> Result<Vec<f32>> {
    Ok(tensor.to_dtype(DType::F32)?.flatten_all()?.to_vec1()?)
}
