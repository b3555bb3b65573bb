//! Prediction of the spectra of any number of links.

use candle_core::DType;

use super::TrainError;
use crate::condition::{Link, ModelInput};
use crate::{ANGLE_BINS, Model};

/// Predicts the spectra of links, `batch` at a time, and hands them over in order: the number of the first link, and
/// spectra of shape (links, [`ANGLE_BINS`]).
///
/// # Errors
/// [`TrainError::Prediction`] when a value is not finite, and whatever `take` returns.
pub fn predict<E: From<TrainError>>(
    model: &dyn Model,
    input: &dyn ModelInput,
    links: impl IntoIterator<Item = Link>,
    batch: usize,
    mut take: impl FnMut(usize, &[f32]) -> Result<(), E>,
) -> Result<(), E> {
    let (mut links, mut first) = (links.into_iter(), 0);
    loop {
        let some: Vec<Link> = links.by_ref().take(batch.max(1)).collect();
        if some.is_empty() {
            return Ok(());
        }
        let spectra = forward(model, input, &some, first)?;
        take(first, &spectra)?;
        first += some.len();
    }
}

fn forward(
    model: &dyn Model,
    input: &dyn ModelInput,
    links: &[Link],
    first: usize,
) -> Result<Vec<f32>, TrainError> {
    let spectra = model.forward_t(&input.batch(links)?, false)?;
    let spectra: Vec<f32> = spectra.to_dtype(DType::F32)?.flatten_all()?.to_vec1()?;
    match spectra.iter().position(|x| !x.is_finite()) {
        Some(i) => Err(TrainError::Prediction {
            link: first + i / ANGLE_BINS,
            bin: i % ANGLE_BINS,
        }),
        None => Ok(spectra),
    }
}
