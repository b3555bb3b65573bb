//! Size of the images: the same model, trained alike on images of another size.

use std::path::Path;

use anyhow::{Context, Result};
use aps_bench::{Config, Profile as Sizes, TestBed, Watch};
use aps_metrics::Metric;
use aps_model::ModelKind;
use aps_report::numbers::three_digits;
use aps_report::trade::Trade;
use serde::Serialize;
use xtask::interrupt::interrupt_flag;
use xtask::note;
use xtask_studies::{Profile, Study};

use crate::watch::Printer;

/// The model under study: the simplest.
const MODEL: ModelKind = ModelKind::ResnetMlp;

#[derive(Debug, Serialize)]
struct Row {
    pixels: usize,
    metres_per_pixel: f64,
    train_s: f64,
    ms_per_link: f64,
    cosine: f64,
    ple_deg: f64,
    recall_4deg: f64,
    mse: f64,
}

/// Measures, on models that learn of `maps`; the data set and the trained models are kept in `work`.
pub fn study(
    profile: Profile,
    seed: u64,
    maps: &str,
    work: &Path,
    study: &mut Study,
) -> Result<()> {
    let sizes: &[usize] = profile.choose(&[32, 64], &[32, 64, 128, 256]);
    let mut config = profile.choose(Sizes::Smoke, Sizes::Quick).config();
    config.seed = seed;
    config.data.maps = maps.into();
    config.model.clear();
    config.data.train_maps = profile.choose(2, 10);
    config.training.links = Some(profile.choose(64, 1500));
    config.training.budget = None;
    config.training.epochs = Some(profile.choose(1, 2));
    config.training.all.batch = Some(profile.choose(16, 64));
    config.data.test_links = Some(profile.choose(40, 1000));
    config.latency.batches = vec![profile.choose(8, 64)];

    let cancel = interrupt_flag()?;
    let printer = Printer::new(cancel);
    let watch = Watch {
        observer: &printer,
        cancel,
    };
    let bed = TestBed::open(&config, work.join("data"), watch)?;
    let mut rows = Vec::new();
    for &pixels in sizes {
        config.training.all.image_size = Some(pixels);
        note!("{MODEL} on images of {pixels} x {pixels}");
        let folder = work.join(format!("{MODEL}-{pixels}"));
        let measured = bed.measure(&config, MODEL, folder, watch)?;
        let latency = measured.latency.first().context("a time was taken")?;
        let mean = |metric| measured.scores.mean(metric).context("it was scored");
        rows.push(Row {
            pixels,
            metres_per_pixel: 256.0 / pixels as f64,
            train_s: measured.training.seconds,
            ms_per_link: latency.median_ms_per_link,
            cosine: mean(Metric::Cosine)?,
            ple_deg: mean(Metric::PleDeg)?,
            recall_4deg: mean(Metric::Recall4Deg)?,
            mse: mean(Metric::Mse)?,
        });
    }
    describe(&config, bed.links(), &rows, study)
}

fn describe(config: &Config, tested: usize, rows: &[Row], study: &mut Study) -> Result<()> {
    study.section.heading("Size of the images");
    let mut trade = Trade::default();
    let name = |row: &Row| format!("{} px", row.pixels);
    for row in rows {
        trade.add(MODEL.name(), name(row), row.ms_per_link, 1.0 - row.cosine);
    }
    let chart = trade.chart("time a link [ms]", "1 \u{2212} CosSim", 1e-4, |_| true);
    study.figure(
        "images-time",
        "Error of the prediction against time a link. Grey: the front.",
        chart.draw(),
    );
    let caption = format!(
        "{MODEL}, small preset, {} epochs on {} links, scored on {tested} links of maps it has not seen",
        config.training.epochs.unwrap_or_default(),
        config.training.links.unwrap_or_default(),
    );
    study.columns(
        caption,
        rows,
        &[
            ("pixels", &|row| row.pixels.to_string()),
            ("a pixel [m]", &|row| three_digits(row.metres_per_pixel)),
            ("training [s]", &|row| three_digits(row.train_s)),
            ("time a link [ms]", &|row| three_digits(row.ms_per_link)),
            ("CosSim", &|row| three_digits(row.cosine)),
            ("PLE [deg]", &|row| three_digits(row.ple_deg)),
            ("Recall@4", &|row| three_digits(row.recall_4deg)),
            ("MSE", &|row| three_digits(row.mse)),
            ("on the front", &|row| trade.on_front(&name(row))),
        ],
    );
    study.data("images", "Every size of image", rows)
}
