//! Builds a model, asks it for the spectra of two links and shows the first bins:
//! `cargo run --release -p aps-model --example untrained`.

use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::{Mode, ModelKind, Parameters, Preset};

fn main() -> Result<(), aps_model::Error> {
    // First values drawn from seed 1.
    let parameters = Parameters::new(&Device::Cpu, DType::F32, 1);
    let model = ModelKind::ResnetMlp.build(Preset::Small, &parameters)?;
    println!("{} learnt values", model.parameters().count());

    // Condition images: buildings, transmitter, receiver. Empty ones here.
    let images = Tensor::zeros((2, 3, 64, 64), DType::F32, &Device::Cpu)?;
    let spectra = model.forward(&images, Mode::Eval)?;
    assert_eq!(spectra.dims(), [2, 180]);
    let first: Vec<f32> = spectra.get(0)?.to_vec1()?;
    println!("first bins of the first spectrum: {:?}", &first[..4]);
    Ok(())
}
