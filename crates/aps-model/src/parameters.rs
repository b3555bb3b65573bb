//! The tensors of a model, by the names PyTorch gives them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use candle_core::{DType, Device, Shape, Tensor, Var};

use crate::Result;

/// Whether an optimizer moves a tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Learnt.
    Trainable,
    /// Kept beside: running statistics of batch normalisation.
    Buffer,
}

/// First values of a tensor, in PyTorch's terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Init {
    /// All the same.
    Constant(f64),
    /// Uniform in [-bound, bound].
    Uniform {
        /// Half the width.
        bound: f64,
    },
    /// Normal with mean 0.
    Normal {
        /// Standard deviation.
        std: f64,
    },
}

/// A tensor and its role.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// The values; layers hold clones of the same storage.
    pub var: Var,
    /// Its role.
    pub kind: Kind,
}

/// All tensors of a model in the order of their names. Cheap to clone: clones share the tensors.
#[derive(Debug, Clone)]
pub struct Parameters {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    device: Device,
    dtype: DType,
    seed: u64,
    tensors: Mutex<BTreeMap<String, Parameter>>,
}

impl Parameters {
    /// An empty set. Initial values are drawn from `seed` and each tensor's name, so that they do not depend on the order
    /// in which a model asks for them.
    pub fn new(device: &Device, dtype: DType, seed: u64) -> Self {
        let inner = Inner {
            device: device.clone(),
            dtype,
            seed,
            tensors: Mutex::default(),
        };
        Self {
            inner: Arc::new(inner),
        }
    }

    /// Where layers ask for their tensors.
    pub fn root(&self) -> Scope {
        Scope {
            parameters: self.clone(),
            prefix: String::new(),
        }
    }

    /// Where the tensors are.
    pub fn device(&self) -> &Device {
        &self.inner.device
    }

    /// All tensors by name.
    pub fn all(&self) -> Vec<(String, Parameter)> {
        let tensors = self.lock();
        tensors
            .iter()
            .map(|(n, p)| (n.clone(), p.clone()))
            .collect()
    }

    /// What an optimizer moves, by name.
    pub fn trainable(&self) -> Vec<(String, Var)> {
        self.all()
            .into_iter()
            .filter(|(_, p)| p.kind == Kind::Trainable)
            .map(|(name, p)| (name, p.var))
            .collect()
    }

    /// Number of trainable values.
    pub fn count(&self) -> usize {
        self.trainable().iter().map(|(_, v)| v.elem_count()).sum()
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Parameter>> {
        self.inner
            .tensors
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

/// A place in the tree of names.
#[derive(Debug, Clone)]
pub struct Scope {
    parameters: Parameters,
    prefix: String,
}

impl Scope {
    /// The place `name` below this one.
    pub fn at(&self, name: impl std::fmt::Display) -> Self {
        Self {
            parameters: self.parameters.clone(),
            prefix: format!("{}{name}.", self.prefix),
        }
    }

    /// Makes the learnt tensor `name` here.
    pub fn trainable(&self, name: &str, shape: impl Into<Shape>, init: Init) -> Result<Tensor> {
        Ok(self
            .make(name, shape.into(), init, Kind::Trainable)?
            .as_tensor()
            .clone())
    }

    /// Makes the buffer `name` here.
    pub fn buffer(&self, name: &str, shape: impl Into<Shape>, init: Init) -> Result<Var> {
        self.make(name, shape.into(), init, Kind::Buffer)
    }

    fn make(&self, name: &str, shape: Shape, init: Init, kind: Kind) -> Result<Var> {
        let _ = (init, self.parameters.inner.seed);
        let inner = &self.parameters.inner;
        let var = Var::zeros(shape, inner.dtype, &inner.device)?;
        let parameter = Parameter {
            var: var.clone(),
            kind,
        };
        self.parameters
            .lock()
            .insert(format!("{}{name}", self.prefix), parameter);
        Ok(var)
    }
}
