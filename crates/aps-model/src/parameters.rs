//! Parameters: the tensors of a model, by the names PyTorch gives them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use candle_core::{DType, Device, Shape, Tensor, Var};

use crate::{Error, Init, Result};

/// The role of a tensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Trainable parameters, which an optimizer updates.
    Trainable,
    /// Running statistics of batch normalisation.
    Buffer,
    /// Training passes seen by a batch normalisation (`num_batches_tracked`): a whole number that no output depends on,
    /// kept so that state dicts go both ways without a tensor too many or too few.
    Counter,
}

/// A tensor and its role.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// The values; layers hold clones of the same storage.
    pub var: Var,
    /// Role of the tensor.
    pub kind: Kind,
}

/// Tensors of a model in the order of their names. Cheap to clone: clones share the tensors.
#[derive(Debug, Clone)]
pub struct Parameters {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    device: Device,
    dtype: DType,
    seed: u64,
    /// True if the tensors are fixed copies of another set's, without gradients.
    is_frozen: bool,
    tensors: Mutex<BTreeMap<String, Parameter>>,
}

impl Parameters {
    /// Creates an empty set whose tensors will be floats of type `dtype` on `device`. Initial values are drawn from `seed`
    /// and each tensor's name, so that they do not depend on the order in which a model asks for them.
    pub fn new(device: &Device, dtype: DType, seed: u64) -> Self {
        let inner = Inner {
            device: device.clone(),
            dtype,
            seed,
            is_frozen: false,
            tensors: Mutex::default(),
        };
        Self {
            inner: Arc::new(inner),
        }
    }

    /// Copies these tensors for a model that is only evaluated. No gradient passes through the copy's weights, so the values
    /// between its layers are freed as soon as the next layer has read them, instead of being kept for a backward pass. The
    /// weights never change, so layers keep what they compute from them (on a CPU, the kernel cache of convolutions: up to
    /// four times the weights' memory).
    ///
    /// Nothing can be loaded into the copy, and it returns no trainable tensors. Do not set a variable of it by hand: the
    /// kernel cache would not follow.
    ///
    /// # Errors
    /// [`Error::Candle`], where there is no memory for the copy.
    ///
    /// ```
    /// use aps_model::candle_core::{DType, Device, Tensor};
    /// use aps_model::{Mode, ModelKind, Parameters, Preset};
    ///
    /// let learning = Parameters::new(&Device::Cpu, DType::F32, 1);
    /// ModelKind::ResnetMlp.build(Preset::Small, &learning)?;
    /// let answering = ModelKind::ResnetMlp.build(Preset::Small, &learning.frozen()?)?;
    /// let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
    /// assert!(!answering.forward(&images, Mode::Eval)?.track_op());
    /// # Ok::<(), aps_model::Error>(())
    /// ```
    pub fn frozen(&self) -> Result<Self> {
        let copy = |(name, p): (String, Parameter)| -> Result<(String, Parameter)> {
            let var = Var::from_tensor(&p.var.as_detached_tensor())?;
            Ok((name, Parameter { var, kind: p.kind }))
        };
        let tensors = self.all().into_iter().map(copy).collect::<Result<_>>()?;
        let inner = Inner {
            device: self.inner.device.clone(),
            dtype: self.inner.dtype,
            seed: self.inner.seed,
            is_frozen: true,
            tensors: Mutex::new(tensors),
        };
        Ok(Self {
            inner: Arc::new(inner),
        })
    }

    /// Returns true when this is a copy by [`frozen`](Self::frozen).
    pub fn is_frozen(&self) -> bool {
        self.inner.is_frozen
    }

    /// Returns the root of the tree of names, from which layers get their tensors.
    pub fn root(&self) -> Scope {
        Scope {
            parameters: self.clone(),
            prefix: String::new(),
        }
    }

    /// Returns the device of the tensors.
    pub fn device(&self) -> &Device {
        &self.inner.device
    }

    /// Returns the type of trainable tensors and running statistics.
    pub fn dtype(&self) -> DType {
        self.inner.dtype
    }

    /// Returns all tensors by name.
    pub fn all(&self) -> Vec<(String, Parameter)> {
        let tensors = self.lock();
        tensors
            .iter()
            .map(|(n, p)| (n.clone(), p.clone()))
            .collect()
    }

    /// Returns the tensor of that name.
    pub fn get(&self, name: &str) -> Option<Parameter> {
        self.lock().get(name).cloned()
    }

    /// Returns the trainable tensors by name; none where the set is [frozen](Self::frozen).
    pub fn trainable(&self) -> Vec<(String, Var)> {
        let learnt = |p: &Parameter| p.kind == Kind::Trainable && !self.is_frozen();
        self.all()
            .into_iter()
            .filter(|(_, p)| learnt(p))
            .map(|(name, p)| (name, p.var))
            .collect()
    }

    /// Returns the number of trainable parameters, frozen or not.
    pub fn count(&self) -> usize {
        let tensors = self.lock();
        let learnt = tensors.values().filter(|p| p.kind == Kind::Trainable);
        learnt.map(|p| p.var.elem_count()).sum()
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
    /// Returns the place `name` below this one.
    pub fn at(&self, name: impl std::fmt::Display) -> Self {
        Self {
            parameters: self.parameters.clone(),
            prefix: format!("{}{name}.", self.prefix),
        }
    }

    /// Returns true when the tensors are [frozen](Parameters::frozen).
    pub fn is_frozen(&self) -> bool {
        self.parameters.is_frozen()
    }

    /// Makes the trainable tensor `name` here.
    ///
    /// # Errors
    /// [`Error::DuplicateTensor`] if there is one of that name already; [`Error::FrozenTensor`] if a frozen set has none.
    pub fn trainable(&self, name: &str, shape: impl Into<Shape>, init: Init) -> Result<Tensor> {
        let var = self.make_float(name, shape.into(), init, Kind::Trainable)?;
        Ok(match self.is_frozen() {
            true => var.as_detached_tensor(),
            false => var.as_tensor().clone(),
        })
    }

    /// Makes the buffer `name` here.
    ///
    /// # Errors
    /// [`Error::DuplicateTensor`] if there is one of that name already.
    pub fn buffer(&self, name: &str, shape: impl Into<Shape>, init: Init) -> Result<Var> {
        self.make_float(name, shape.into(), init, Kind::Buffer)
    }

    /// Makes the counter `name` here, a scalar i64 that starts at 0.
    ///
    /// # Errors
    /// [`Error::DuplicateTensor`] if there is one of that name already.
    pub fn counter(&self, name: &str) -> Result<Var> {
        if self.is_frozen() {
            return self.find(name, &Shape::from(()));
        }
        let var = Var::zeros((), DType::I64, self.parameters.device())?;
        self.insert(name, var, Kind::Counter)
    }

    fn make_float(&self, name: &str, shape: Shape, init: Init, kind: Kind) -> Result<Var> {
        let Inner {
            device,
            dtype,
            seed,
            is_frozen,
            ..
        } = &*self.parameters.inner;
        if *is_frozen {
            return self.find(name, &shape);
        }
        let values = init.values(*seed, &self.full(name), shape.elem_count());
        let values = Tensor::from_vec(values, shape, &Device::Cpu)?
            .to_dtype(*dtype)?
            .to_device(device)?;
        self.insert(name, Var::from_tensor(&values)?, kind)
    }

    /// The tensor of a frozen set.
    fn find(&self, name: &str, shape: &Shape) -> Result<Var> {
        let name = self.full(name);
        match self.parameters.get(&name) {
            Some(found) if found.var.shape() == shape => Ok(found.var),
            found => Err(Error::FrozenTensor {
                name,
                expected: shape.dims().to_vec(),
                found: found.map(|p| p.var.dims().to_vec()),
            }),
        }
    }

    fn insert(&self, name: &str, var: Var, kind: Kind) -> Result<Var> {
        let name = self.full(name);
        let parameter = Parameter {
            var: var.clone(),
            kind,
        };
        match self.parameters.lock().insert(name.clone(), parameter) {
            None => Ok(var),
            Some(_) => Err(Error::DuplicateTensor { name }),
        }
    }

    fn full(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }
}
