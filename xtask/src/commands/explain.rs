//! `cargo xtask explain`: every lobe of a spectrum with the path that makes it and its mirror lobe.

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use aps_label::{LabelConfig, Protocol};
use aps_raytrace::Tracer;
use aps_raytrace::glam::DVec2;
use aps_report::explain::{Explained, Explanation};
use aps_report::link::{LinkView, heading_words};
use aps_report::picture::Outlines;

use map2aps::maps::NamedMaps;
use map2aps::{Limits, counted, is_near};

use crate::args::{ArrayArgs, OneMapArgs, TraceArgs, parse_heading, parse_point};
use crate::cautions;
use crate::output;
use crate::say;
use crate::source::{LinkId, Source};

/// Show which path makes which lobe of a spectrum.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of a data set.
    #[arg(conflicts_with_all = ["map", "tx", "rx"], requires = "link")]
    dataset: Option<PathBuf>,
    /// A link of the data set: MAP,TX,RX, the rows of its transmitter and receiver.
    #[arg(long, requires = "dataset")]
    link: Option<LinkId>,
    /// With a data set that stores no paths, the maps it was made from: a folder of RadioMapSeer files, or the GeoJSON file of
    /// the city, which is cut as it was. Synthetic ones are found without.
    #[arg(long, requires = "dataset")]
    maps: Option<NamedMaps>,
    /// Without a data set, the map to trace a link on: a RadioMapSeer file, a city in a GeoJSON file, or synthetic for the made-up city of --seed.
    #[arg(long, requires_all = ["tx", "rx"])]
    map: Option<PathBuf>,
    /// Transmitter X,Y [m].
    #[arg(long, value_parser = parse_point, allow_hyphen_values = true, requires = "map")]
    tx: Option<DVec2>,
    /// Receiver X,Y [m].
    #[arg(long, value_parser = parse_point, allow_hyphen_values = true, requires = "map")]
    rx: Option<DVec2>,
    /// Definition of the spectrum whose lobes are explained: paper or released [default: the data set's, or paper].
    #[arg(long)]
    protocol: Option<Protocol>,
    #[command(flatten)]
    array: ArrayArgs,
    /// Heading of the array [deg], counter-clockwise from +x: angles are counted from there.
    #[arg(long, value_name = "DEG", default_value_t = 0.0, allow_negative_numbers = true, value_parser = parse_heading)]
    heading: f64,
    /// File to write: .html for a page, .svg for a picture.
    #[arg(long)]
    out: PathBuf,
    #[command(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    one_map: OneMapArgs,
}

/// A link with everything that is to be shown of it.
struct Subject {
    title: String,
    outlines: Outlines,
    link: LinkView,
    label: LabelConfig,
}

impl Args {
    /// Runs the command.
    pub fn run(self) -> Result<()> {
        let form = self.out.extension().and_then(|e| e.to_str());
        let is_page = match form {
            Some("html") => true,
            Some("svg") => false,
            _ => bail!("--out '{}': name a file .html or .svg", self.out.display()),
        };
        output::make_folder_of(&self.out)?;
        let mut subject = self.subject()?;
        subject.title += &heading_words(self.heading);
        subject.link = subject.link.from_heading(self.heading);
        let protocol = self.protocol.unwrap_or(subject.label.protocol);
        let explanation =
            Explanation::of(&subject.link, protocol, &subject.label)?.with_context(|| {
                format!(
                    "{}: it has no path that the {protocol} protocol counts",
                    subject.title
                )
            })?;
        let picture = Explained {
            title: &subject.title,
            outlines: &subject.outlines,
            explanation: &explanation,
        };
        if is_page {
            picture.page().save_html(&self.out)?;
        } else {
            picture.drawing().save(&self.out)?;
        }
        say!(
            "{}: {}, {}: '{}'",
            subject.title,
            counted(explanation.lobes.len(), "lobe", "lobes"),
            counted(subject.link.paths.len(), "path", "paths"),
            self.out.display()
        )?;
        Ok(())
    }

    fn subject(&self) -> Result<Subject> {
        let config = self.trace.config();
        if let (Some(folder), Some(id)) = (&self.dataset, self.link) {
            ensure!(
                config == Limits::default().config() && self.one_map.is_usual_scene(),
                "settings of the trace and of the scene are for --map: the paths of a data set are those that it was made with"
            );
            let source = Source::open(folder, self.maps.as_ref(), &self.one_map.tiles)?;
            let map = source.map(id.map)?;
            let row = map.row_of(id.tx, id.rx)?;
            source.must_have_paths(&map, row)?;
            return Ok(Subject {
                title: format!("Map {}, transmitter {}, receiver {}", id.map, id.tx, id.rx),
                link: map.links(&[row])?.remove(0),
                outlines: map.outlines,
                label: self.array.over(source.label()),
            });
        }
        let (Some(file), Some(tx), Some(rx)) = (&self.map, self.tx, self.rx) else {
            bail!("name a link: DATASET --link MAP,TX,RX, or --map FILE --tx X,Y --rx X,Y");
        };
        let scene = self.one_map.load(file)?;
        let tracer = Tracer::new(&scene, config.clone())?;
        let link = tracer.trace(tx, rx)?;
        cautions::tell_carrier(&config);
        cautions::tell_near(&config, is_near(&config, tx, rx).into());
        Ok(Subject {
            title: format!("From ({}, {}) m to ({}, {}) m", tx.x, tx.y, rx.x, rx.y),
            outlines: Outlines::of_scene(&scene),
            link: LinkView::traced(tx, rx, &link.paths),
            label: self.array.over(&LabelConfig::default()),
        })
    }
}
