//! Precision and size of batch: outputs against those in double precision.

use anyhow::Result;
use aps_model::candle_core::{DType, Device, Tensor};
use aps_model::candle_nn::VarMap;
use aps_model::condition::{
    ConditionConfig, ConditionImages, InputShape, Link, ModelInput, Rasters,
};
use aps_model::{Model, ModelKind, Preset, frozen, seeded};
use aps_report::numbers::{small, three_digits};
use aps_report::trade::Trade;
use serde::Serialize;
use xtask_studies::{Profile, Stopwatch, Study};

/// Rows and columns of the images.
const PIXELS: usize = 64;

#[derive(Debug, Serialize)]
struct Row {
    model: &'static str,
    precision: &'static str,
    batch: usize,
    ms_per_link: f64,
    /// Root of the mean squared difference, relative to that of the outputs in double precision about their mean.
    relative_error: f64,
    /// Largest difference, in the unit of normalised spectra.
    largest_error: f64,
}

/// Measures.
pub fn study(profile: Profile, seed: u64, study: &mut Study) -> Result<()> {
    let kinds: &[ModelKind] = profile.choose(
        &[ModelKind::ResnetMlp],
        &[
            ModelKind::ResnetMlp,
            ModelKind::MsAreg,
            ModelKind::ResnetConv1d,
            ModelKind::RadioUnet,
            ModelKind::VitReg,
        ],
    );
    let batches: &[usize] = profile.choose(&[1, 2], &[1, 8, 64]);
    let (mut rows, mut refused) = (Vec::new(), Vec::new());
    for &kind in kinds {
        let exact = Network::new(kind, DType::F64, seed)?;
        for (name, precision) in [("f32", DType::F32), ("bf16", DType::BF16)] {
            let network = Network::new(kind, precision, seed)?;
            for &batch in batches {
                match measure(profile, &exact, &network, batch) {
                    Ok([ms_per_link, relative_error, largest_error]) => rows.push(Row {
                        model: kind.name(),
                        precision: name,
                        batch,
                        ms_per_link,
                        relative_error,
                        largest_error,
                    }),
                    Err(error) => {
                        let whole = xtask::output::told(error.as_ref());
                        let reason = whole.lines().next().unwrap_or_default();
                        refused.push(format!(
                            "{} in {name} does not run here: {reason}",
                            kind.name()
                        ));
                        break;
                    }
                }
            }
        }
    }
    describe(&rows, refused, batches, study)
}

fn describe(
    rows: &[Row],
    refused: Vec<String>,
    batches: &[usize],
    study: &mut Study,
) -> Result<()> {
    study.section.heading("Precision and batches");
    let largest = *batches.last().expect("there is a batch");
    let mut trade = Trade::default();
    for row in rows.iter().filter(|row| row.batch == largest) {
        let name = format!("{} {}", row.model, row.precision);
        trade.add(row.precision, name, row.ms_per_link, row.relative_error);
    }
    let chart = trade.chart("time a link [ms]", "relative error", 1e-9, |_| true);
    let caption = format!(
        "Error of the output against time a link, {largest} links at once. Grey: the front."
    );
    study.figure("precision-time", caption, chart.draw());
    for reason in refused {
        study.section.text(reason);
    }
    // By the same model one link at a time, and by the same model in single precision.
    let find = |row: &Row, precision: &str, batch: usize| {
        rows.iter()
            .find(|r| r.model == row.model && r.precision == precision && r.batch == batch)
    };
    let time_over = |row: &Row, other: Option<&Row>| {
        other.map_or(String::new(), |o| small(row.ms_per_link / o.ms_per_link))
    };
    let of_smallest_batch = |row: &Row| time_over(row, find(row, row.precision, batches[0]));
    let of_f32 = |row: &Row| time_over(row, find(row, "f32", row.batch));
    let caption = format!(
        "Small preset with its initial weights, {PIXELS} x {PIXELS} images; errors against double precision, relative to the \
         deviation of its outputs"
    );
    study.columns(
        caption,
        rows,
        &[
            ("model", &|row| row.model.into()),
            ("precision", &|row| row.precision.into()),
            ("batch", &|row| row.batch.to_string()),
            ("time a link [ms]", &|row| three_digits(row.ms_per_link)),
            ("relative error", &|row| small(row.relative_error)),
            ("largest error", &|row| small(row.largest_error)),
            ("time, of the smallest batch", &of_smallest_batch),
            ("time, of f32", &of_f32),
        ],
    );
    study.data("precision", "Every model, precision and batch", rows)
}

/// A model with images to answer.
struct Network {
    model: Box<dyn Model>,
    dtype: DType,
}

impl Network {
    fn new(kind: ModelKind, dtype: DType, seed: u64) -> Result<Self> {
        let parameters = VarMap::new();
        kind.build(
            Preset::Small,
            InputShape::Images,
            seeded(&parameters, seed, dtype, &Device::Cpu),
        )?;
        Ok(Self {
            model: kind.build(Preset::Small, InputShape::Images, frozen(&parameters)?)?,
            dtype,
        })
    }
}

/// Time a link \[ms\], relative and largest error.
fn measure(profile: Profile, exact: &Network, network: &Network, batch: usize) -> Result<[f64; 3]> {
    let images = images(batch)?;
    let values = |network: &Network| -> Result<Vec<f64>> {
        let y = network
            .model
            .forward_t(&images.to_dtype(network.dtype)?, false)?;
        Ok(y.to_dtype(DType::F64)?.flatten_all()?.to_vec1()?)
    };
    let (expected, found) = (values(exact)?, values(network)?);
    let n = expected.len() as f64;
    let mean = expected.iter().sum::<f64>() / n;
    let spread = expected.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
    let differences = || expected.iter().zip(&found).map(|(e, f)| e - f);
    let relative = (differences().map(|d| d * d).sum::<f64>() / spread).sqrt();
    let largest = differences().fold(0.0, |worst: f64, d| worst.max(d.abs()));
    let images = images.to_dtype(network.dtype)?;
    let seconds = Stopwatch::of(profile).time(|| {
        // It ran above.
        let _ = std::hint::black_box(network.model.forward_t(&images, false));
    });
    Ok([1e3 * seconds / batch as f64, relative, largest])
}

/// Links across a block of houses.
fn images(batch: usize) -> Result<Tensor> {
    let is_house = |at: usize| at % 64 > 16 && at / 256 % 64 > 16;
    let pixels: Vec<f32> = (0..256 * 256).map(|at| f32::from(is_house(at))).collect();
    let rasters = Rasters {
        pixels: &pixels,
        height: 256,
        width: 256,
        metres_per_pixel: 1.0,
    };
    let config = ConditionConfig {
        image_size: PIXELS,
        ..ConditionConfig::default()
    };
    let place = |i: usize, k: usize| (i * k * 37 + 8 * k) as f64 % 256.0;
    let link = |i: usize| Link {
        map: 0,
        tx_m: [place(i, 1), place(i, 3)],
        rx_m: [place(i, 5), place(i, 7)],
    };
    let links: Vec<Link> = (0..batch).map(link).collect();
    let input = ConditionImages::new(rasters, config, &Device::Cpu)?;
    Ok(input.batch(&links)?)
}
