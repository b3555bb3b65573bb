//! Devices to compute on.

use anyhow::{Context, Result};
use aps_model::candle_core;
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Device that holds the tensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// The processor.
    Cpu,
    /// The first NVIDIA GPU.
    Cuda,
    /// The first Apple GPU.
    Metal,
}

impl Device {
    /// Opens the device.
    pub fn open(self) -> Result<candle_core::Device> {
        match self {
            Device::Cpu => Ok(candle_core::Device::Cpu),
            Device::Cuda => candle_core::Device::new_cuda(0)
                .context("--device cuda needs an NVIDIA GPU and a build with the feature cuda"),
            Device::Metal => candle_core::Device::new_metal(0)
                .context("--device metal needs an Apple GPU and a build with the feature metal"),
        }
    }
}
