//! `cargo xtask trace`: the paths of single links, as JSON, CSV, a table or a picture.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use aps_label::{LabelConfig, Labeler, Protocol};
use aps_raytrace::glam::DVec2;
use aps_raytrace::{Link, Scene, Tracer};
use aps_report::link::{LinkView, PathView, Spectrum, has_mirrors};
use aps_report::picture::{self, Outlines};
use clap::ValueEnum;

use map2aps::path_list::{LinkEntry, LinkList};
use map2aps::{counted, is_near};

use crate::args::{OneMapArgs, TraceArgs, parse_point};
use crate::cautions;
use crate::note;
use crate::output;

/// Forms of output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    Json,
    Csv,
    Table,
}

/// Trace single links and print or draw their paths.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A RadioMapSeer file, a city in a GeoJSON file, or synthetic for the made-up city of --seed.
    #[arg(long, visible_alias = "maps", default_value = "synthetic")]
    map: PathBuf,
    /// Transmitter X,Y [m].
    #[arg(long, value_parser = parse_point, requires = "rx", allow_hyphen_values = true)]
    tx: Option<DVec2>,
    /// Receiver X,Y [m]; may be given many times.
    #[arg(long, value_parser = parse_point, requires = "tx", allow_hyphen_values = true)]
    rx: Vec<DVec2>,
    /// CSV with columns tx_x,tx_y,rx_x,rx_y [m], one link a row.
    #[arg(long, conflicts_with_all = ["tx", "rx"])]
    links: Option<PathBuf>,
    /// Form of the output.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Draw the (first) link: map, paths, APS.
    #[arg(long)]
    svg: Option<PathBuf>,
    /// Definition of the APS in the picture.
    #[arg(long, default_value_t)]
    protocol: Protocol,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    one_map: OneMapArgs,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let ends = self.ends()?;
        self.svg.as_deref().map_or(Ok(()), output::make_folder_of)?;
        let scene = self.one_map.load(&self.map)?;
        let config = self.trace.config();
        let tracer = Tracer::new(&scene, config.clone())?;
        let links = trace_all(&tracer, &ends)?;
        cautions::tell_carrier(&config);
        let near = ends.iter().filter(|(tx, rx)| is_near(&config, *tx, *rx));
        cautions::tell_near(&config, near.count() as u64);
        match self.format {
            Format::Json => print_json(&ends, &links)?,
            Format::Csv => print_csv(&ends, &links)?,
            Format::Table => print_table(&ends, &links)?,
        }
        if let Some(file) = &self.svg {
            let (tx, rx) = ends[0];
            self.draw(file, &scene, tx, rx, &links[0])?;
        }
        Ok(())
    }

    /// Transmitter and receiver of each link.
    fn ends(&self) -> Result<Vec<(DVec2, DVec2)>> {
        let Some(file) = &self.links else {
            let Some(tx) = self.tx else {
                bail!("give a link: --tx X,Y --rx X,Y, or --links FILE.csv");
            };
            return Ok(self.rx.iter().map(|&rx| (tx, rx)).collect());
        };
        let place = || format!("links '{}'", file.display());
        let mut reader = csv::Reader::from_path(file).with_context(place)?;
        let mut ends = Vec::new();
        for row in reader.deserialize() {
            let expected = || {
                format!(
                    "{}: expected columns tx_x,tx_y,rx_x,rx_y in metres",
                    place()
                )
            };
            let row: LinkRow = row.with_context(expected)?;
            ends.push(((row.tx_x, row.tx_y).into(), (row.rx_x, row.rx_y).into()));
        }
        ensure!(!ends.is_empty(), "{}: no link in it", place());
        Ok(ends)
    }

    fn draw(&self, file: &Path, scene: &Scene, tx: DVec2, rx: DVec2, link: &Link) -> Result<()> {
        let labeler = Labeler::new(&LabelConfig::of(self.protocol))?;
        let view = LinkView::traced(tx, rx, &link.paths);
        let spectrum = Spectrum::of(&labeler, &view.samples())?;
        let outlines = Outlines::of_scene(scene);
        let has_mirrors = has_mirrors(labeler.config());
        picture::link(&outlines, &view, spectrum.as_ref(), has_mirrors).save(file)?;
        note!("picture '{}'", file.display());
        Ok(())
    }
}

#[derive(Debug, serde::Deserialize)]
struct LinkRow {
    tx_x: f64,
    tx_y: f64,
    rx_x: f64,
    rx_y: f64,
}

/// Traces every link; all ends that cannot stand where they are told at once.
fn trace_all(tracer: &Tracer<'_>, ends: &[(DVec2, DVec2)]) -> Result<Vec<Link>> {
    let (mut links, mut errors) = (Vec::new(), Vec::new());
    for (i, &(tx, rx)) in ends.iter().enumerate() {
        match tracer.trace(tx, rx) {
            Ok(link) => links.push(link),
            Err(error) => errors.push(format!("link {i}: {}", output::told(&error))),
        }
    }
    ensure!(errors.is_empty(), "{}", errors.join("\n"));
    Ok(links)
}

fn print_json(ends: &[(DVec2, DVec2)], links: &[Link]) -> Result<()> {
    let entry = |(&(tx, rx), link): (&(DVec2, DVec2), &Link)| LinkEntry::new(tx, rx, &link.paths);
    let links = ends.iter().zip(links).map(entry).collect();
    let list = LinkList { links };
    writeln!(output::stdout(), "{}", serde_json::to_string_pretty(&list)?)?;
    Ok(())
}

/// Head of the output as CSV.
const CSV_HEAD: &str = "link,tx_x,tx_y,rx_x,rx_y,path,interactions,\
    length_m,delay_s,departure_azimuth_rad,arrival_azimuth_rad,gain_db";

fn print_csv(ends: &[(DVec2, DVec2)], links: &[Link]) -> Result<()> {
    let mut out = csv::Writer::from_writer(output::stdout());
    out.write_record(CSV_HEAD.split(','))?;
    for (i, (&(tx, rx), link)) in ends.iter().zip(links).enumerate() {
        for (k, p) in link.paths.iter().enumerate() {
            out.serialize((
                (i, tx.x, tx.y, rx.x, rx.y, k, PathView::from(p).name()),
                (
                    p.length_m,
                    p.delay_s,
                    p.departure_azimuth_rad,
                    p.arrival_azimuth_rad,
                ),
                p.gain_db(),
            ))?;
        }
    }
    out.flush()?;
    Ok(())
}

fn print_table(ends: &[(DVec2, DVec2)], links: &[Link]) -> Result<()> {
    let mut out = output::stdout();
    for ((tx, rx), link) in ends.iter().zip(links) {
        writeln!(
            out,
            "tx ({}, {}) -> rx ({}, {}): {}",
            tx.x,
            tx.y,
            rx.x,
            rx.y,
            counted(link.paths.len(), "path", "paths")
        )?;
        if let Some(d) = link.fallback_diffractions {
            writeln!(out, "  none inside the limits; chains of {d} diffractions:")?;
        }
        writeln!(
            out,
            "   length m   delay ns  depart deg  arrive deg   gain dB  interactions"
        )?;
        for p in &link.paths {
            writeln!(
                out,
                "{:>11.3} {:>10.2} {:>11.2} {:>11.2} {:>9.2}  {}",
                p.length_m,
                p.delay_s * 1e9,
                p.departure_azimuth_rad.to_degrees(),
                p.arrival_azimuth_rad.to_degrees(),
                p.gain_db(),
                PathView::from(p).name()
            )?;
        }
    }
    Ok(())
}
