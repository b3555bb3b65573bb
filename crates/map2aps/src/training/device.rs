//! Devices to compute on.

use std::fmt;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use aps_model::candle_core;
use aps_model::train::Precision;
use serde::{Deserialize, Serialize};

use super::TrainingError;
use crate::error::Result;

/// Device that holds the tensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// The processor.
    #[default]
    Cpu,
    /// The first NVIDIA GPU.
    Cuda,
    /// The first Apple GPU.
    Metal,
}

impl Device {
    /// Every device that this version knows.
    pub const ALL: [Self; 3] = [Self::Cpu, Self::Cuda, Self::Metal];

    /// Opens the device, once for all of the program.
    ///
    /// # Errors
    /// [`TrainingError::Device`] when the device, or the feature of this crate for it, is not there.
    pub fn open(self) -> Result<candle_core::Device> {
        // A second handle of a GPU would be another device to candle.
        static OPEN: Mutex<Vec<(Device, candle_core::Device)>> = Mutex::new(Vec::new());
        let mut open = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, found)) = open.iter().find(|(device, _)| *device == self) {
            return Ok(found.clone());
        }
        let opened = match self {
            Self::Cpu => Ok(candle_core::Device::Cpu),
            Self::Cuda => candle_core::Device::new_cuda(0),
            Self::Metal => candle_core::Device::new_metal(0),
        };
        let opened = opened.map_err(|source| TrainingError::Device {
            device: self.name(),
            hardware: self.hardware(),
            source,
        })?;
        open.push((self, opened.clone()));
        Ok(opened)
    }

    /// Numbers that a training on the device computes with unless others are asked for: a GPU multiplies bf16 several times as fast.
    pub fn usual_precision(self) -> Precision {
        match self {
            Self::Cpu => Precision::Full,
            Self::Cuda | Self::Metal => Precision::Mixed,
        }
    }

    /// Name of the device.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
            Self::Metal => "metal",
        }
    }

    /// Hardware that the device needs.
    fn hardware(self) -> &'static str {
        match self {
            Self::Cpu => "a processor",
            Self::Cuda => "an NVIDIA GPU",
            Self::Metal => "an Apple GPU",
        }
    }
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Device {
    type Err = TrainingError;

    fn from_str(text: &str) -> Result<Self, TrainingError> {
        let found = Self::ALL.into_iter().find(|device| device.name() == text);
        found.ok_or_else(|| TrainingError::UnknownDevice(text.into()))
    }
}
