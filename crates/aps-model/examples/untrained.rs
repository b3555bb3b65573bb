//! Builds a model, predicts the spectra of two links and shows the first bins:
//! `cargo run --release -p aps-model --example untrained`.

use aps_model::candle_core::{DType, Device, Error, Tensor};
use aps_model::candle_nn::VarMap;
use aps_model::condition::InputShape;
use aps_model::{ModelKind, Preset, seeded};

fn main() -> Result<(), Error> {
    // Initial weights drawn from seed 1.
    let parameters = VarMap::new();
    let vb = seeded(&parameters, 1, DType::F32, &Device::Cpu);
    let model = ModelKind::ResnetMlp.build(Preset::Small, InputShape::Images, vb)?;

    // Condition images: buildings, transmitter, receiver. Empty ones here.
    let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
    let spectra = model.forward_t(&images, false)?;
    assert_eq!(spectra.dims(), [2, 180]);
    let first: Vec<f32> = spectra.get(0)?.to_vec1()?;
    println!("first bins of the first spectrum: {:?}", &first[..4]);
    Ok(())
}
