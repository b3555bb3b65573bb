//! Trains a model in candle's own terms, three steps: `VarMap`, `VarBuilder`, a loss, `AdamW`. Nothing of this crate but the
//! model itself: `cargo run --release -p aps-model --example plain_candle`.

use aps_model::candle_core::{DType, Device, Error, Tensor};
use aps_model::candle_nn::{AdamW, Optimizer, VarBuilder, VarMap, loss};
use aps_model::condition::InputShape;
use aps_model::{ModelKind, Preset};

fn main() -> Result<(), Error> {
    let device = Device::Cpu;
    let varmap = VarMap::new();
    let vb = VarBuilder::from_varmap(&varmap, DType::F32, &device);
    let model = ModelKind::ResnetMlp.build(Preset::Small, InputShape::Images, vb)?;
    let mut optimizer = AdamW::new_lr(varmap.all_vars(), 1e-3)?;

    // A batch of condition images and normalised spectra.
    let images = Tensor::rand(0f32, 1.0, (4, 3, 64, 64), &device)?;
    let targets = Tensor::randn(0f32, 1.0, (4, 180), &device)?;
    for step in 0..3 {
        let predicted = model.forward_t(&images, true)?;
        let loss = loss::mse(&predicted, &targets)?;
        optimizer.backward_step(&loss)?;
        println!("step {step}: loss {}", loss.to_scalar::<f32>()?);
    }
    let spectra = model.forward_t(&images, false)?;
    println!("predicted {:?}", spectra.dims());
    Ok(())
}
