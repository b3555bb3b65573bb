//! `cargo xtask predict`: spectra from trained weights.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use aps_data::npy::{self, Element};
use aps_data::{Part, PartialFile};
use aps_model::ANGLE_BINS;
use aps_model::condition::{ConditionConfig, InputKind};
use indicatif::ProgressBar;
use map2aps::maps::NamedMaps;
use map2aps::targets::{self, Target};
use map2aps::training::{self, Device, Trained};
use map2aps::{Examples, LINK_COLUMNS, link_labels, link_line, links_file};
use xtask::interrupt::interrupt_flag;
use xtask::progress::bar_of;
use xtask::{TileArgs, note, parts};

use crate::choices::devices;
use crate::weights::{WeightsArgs, advised, size_assumed};

/// Closing section of the long help: facts that the options' single lines leave out.
const WHAT_IS_WRITTEN: &str = "\
The links with a label (status 0) of the split's maps are predicted: maps in ascending order, links in the
order of their rows. This is what the metrics expect:

  cargo xtask metrics --truth DATA --split test --prediction pred.npy

pred.links.csv, beside pred.npy, names map, row, transmitter, receiver and labels of each.";

/// Predict spectra with a trained model.
#[derive(Debug, clap::Args)]
#[command(after_long_help = WHAT_IS_WRITTEN)]
pub struct Args {
    #[command(flatten)]
    weights: WeightsArgs,
    /// Folder of a data set.
    #[arg(long)]
    data: PathBuf,
    /// Part of the data set.
    #[arg(long, value_parser = parts(), default_value = Part::Test.name())]
    split: Part,
    /// Maps that the data set was made from, for polar_reg: a folder of RadioMapSeer files, or a city in GeoJSON. Synthetic
    /// cities need not be given.
    #[arg(long)]
    maps: Option<NamedMaps>,
    #[command(flatten)]
    tiles: TileArgs,
    /// Rows and columns of condition images [pixels; default: as trained, by the config.json beside the weights; else
    /// 256 paper, 64 small].
    #[arg(long)]
    image_size: Option<usize>,
    /// Links predicted at a time. Sums of other sizes may round the last digits differently.
    #[arg(long, default_value_t = 64)]
    batch: usize,
    /// Device to compute on.
    #[arg(long, value_parser = devices(), default_value_t = Device::Cpu)]
    device: Device,
    /// Threads [default: all cores].
    #[arg(long)]
    threads: Option<usize>,
    /// File to write: .npy, (links, 180), float32.
    #[arg(long)]
    out: PathBuf,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        xtask::use_threads(self.threads)?;
        ensure!(self.batch > 0, "--batch must be at least 1");
        ensure!(
            self.out.extension().is_some_and(|ending| ending == "npy"),
            "--out '{}' must be a file named .npy",
            self.out.display()
        );
        xtask::output::make_folder_of(&self.out)?;
        let device = self.device.open()?;
        let load = |file: &_, kind, preset| Trained::load(file, kind, preset, &device);
        let shipped = |kind| Trained::shipped(kind, &device);
        let trained = self.weights.read(load, shipped)?;
        let kind = trained.label().kind;
        self.weights.check(trained.label(), trained.report())?;
        ensure!(
            self.image_size.is_none() || kind.input() == InputKind::Images,
            "--image-size is for models of images, not for {kind}"
        );
        self.predict(trained)
    }

    fn predict(&self, trained: Trained) -> Result<()> {
        let root = self.data.as_path();
        let dataset = training::open(root)?;
        let configuration = &dataset.manifest().configuration;
        let maps = self.tiles.open_for(self.maps.as_ref(), configuration)?;
        let trained = trained.with_maps(maps);
        let (.., target) = targets::learning_target(&dataset)?;
        let trained = &trained.for_targets(target);
        let part = self.split;
        let maps = targets::maps_of(&dataset, part)?;
        let images = self.images_of(trained);
        for difference in trained.differences(&dataset).map_err(advised)? {
            let place = root.display();
            note!("note: the model learnt other labels than those of '{place}': {difference}");
        }
        if trained.settings().is_none() {
            note!(
                "note: no config.json lies beside the weights: nothing tells which labels the model learnt"
            );
        }
        if let (Some(size), None) = (trained.assumed_image_size(), self.image_size) {
            note!("{}", size_assumed(size, "--image-size sets it"));
        }
        let mut output = Output::create(&self.out, targets::labelled_links(&dataset, maps))?;
        let (links, file) = PartialFile::create(&links_file(&self.out))?;
        let mut names = BufWriter::new(file);
        writeln!(names, "{LINK_COLUMNS}")?;
        let labels = link_labels(&dataset);
        // A map at a time: its labels are not needed, but its links and buildings are.
        for &id in maps {
            let examples = Examples::of_maps(&dataset, &[id], Target::Linear, None)?;
            for (offset, example) in examples.list().iter().enumerate() {
                let line = link_line(&labels, output.rows + offset, example);
                writeln!(names, "{line}")?;
            }
            let input = trained.input(&examples, images).map_err(advised)?;
            trained.predict_batches(&*input, &examples, self.batch, |spectra| {
                output.push(spectra)
            })?;
        }
        let place = || format!("cannot write '{}'", links_file(&self.out).display());
        let names = names.into_inner().map_err(|e| e.into_error());
        // Both take their names when both are whole.
        let rows = output.finish(|| Ok(links.complete(names.with_context(place)?)?))?;
        note!(
            "{rows} spectra of the {} maps {maps:?} in '{}', their links in '{}'",
            part.name(),
            self.out.display(),
            links_file(&self.out).display()
        );
        Ok(())
    }

    fn images_of(&self, trained: &Trained) -> ConditionConfig {
        let own = trained.images();
        let image_size = self.image_size.unwrap_or(own.image_size);
        if trained.settings().is_some() && image_size != own.image_size {
            let own = own.image_size;
            note!("note: the model was trained on images of {own} pixels, not {image_size}");
        }
        ConditionConfig { image_size, ..own }
    }
}

/// A growing array of spectra, under another name until it is whole.
struct Output {
    writer: npy::Writer<BufWriter<File>>,
    partial: PartialFile,
    path: PathBuf,
    rows: usize,
    bar: ProgressBar,
    interrupted: &'static AtomicBool,
}

impl Output {
    fn create(path: &Path, rows: usize) -> Result<Self> {
        let interrupted = interrupt_flag()?;
        let (partial, file) = PartialFile::create(path)?;
        let template = "[{bar:40}] {human_pos}/{human_len} spectra, {per_sec}, {eta} left";
        Ok(Self {
            writer: npy::Writer::new(BufWriter::new(file), f32::DTYPE, &[ANGLE_BINS])?,
            partial,
            path: path.into(),
            rows: 0,
            bar: bar_of(rows as u64, template),
            interrupted,
        })
    }

    fn push(&mut self, spectra: &[f32]) -> map2aps::Result<()> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Err(map2aps::Error::Cancelled);
        }
        self.writer
            .push(spectra)
            .map_err(|source| map2aps::Error::At {
                place: map2aps::error::Place::Writing(self.path.clone()),
                source: Box::new(source.into()),
            })?;
        let rows = spectra.len() / ANGLE_BINS;
        self.rows += rows;
        self.bar.inc(rows as u64);
        Ok(())
    }

    /// Gives the array its name, after `others` have theirs.
    fn finish(self, others: impl FnOnce() -> Result<()>) -> Result<usize> {
        self.bar.finish_and_clear();
        let place = || format!("cannot write '{}'", self.path.display());
        let (sink, rows) = self.writer.finish().with_context(place)?;
        let file = sink.into_inner().map_err(|e| e.into_error());
        let file = file.with_context(place)?;
        file.sync_all().with_context(place)?;
        others()?;
        self.partial.complete(file)?;
        Ok(rows)
    }
}
