//! The answer about one link: its paths, its spectra, its lobes.

use std::sync::Arc;
use std::time::Instant;

use aps_raytrace::Link;
use aps_raytrace::glam::DVec2;
use aps_report::explain::{Explanation, LOBE_COLUMNS, PATH_COLUMNS};
use aps_report::link::{LinkView, PathView, Spectrum, angle_deg, mirror_deg};
use map2aps::path_list::LinkEntry;
use serde::Serialize;

use crate::cache::{Cache, City, TxSide};
use crate::curve::Curve;
use crate::fault::Fault;
use crate::prediction::Prediction;
use crate::request::{LabelChoice, LinkQuestion};
use crate::request_handle::RequestHandle;
use crate::times::{Times, us};

/// A link traced, as its array sees it.
#[derive(Debug)]
pub struct Traced {
    /// The map.
    pub city: Arc<City>,
    /// The link.
    pub link: Link,
    /// The link for pictures, arrival azimuths counted from the heading of the array.
    pub view: LinkView,
    /// Times of the stages.
    pub times: Times,
}

impl Traced {
    /// Traces a link.
    ///
    /// # Errors
    /// Maps, terminals and links that cannot be used, and [`Fault::Overtaken`].
    pub fn new(
        cache: &Cache,
        question: &LinkQuestion,
        handle: &RequestHandle,
    ) -> Result<Self, Fault> {
        handle.check()?;
        let city = cache.city(&question.city)?;
        let TxSide { tracer, tx } =
            cache.tx_side(&city, &question.trace.config()?, question.tx, handle)?;
        let rx = cache.receiver(&tracer, question.rx)?;
        handle.check()?;
        let began = Instant::now();
        let mut link = Link::default();
        let joined = tracer.value.link(&tx.value, &rx.value, &mut link);
        joined.map_err(Fault::of)?;
        let times = Times {
            map: us(tracer.took),
            tx: us(tx.took),
            rx: us(rx.took),
            join: us(began.elapsed()),
            label: 0.0,
        };
        let [from, to] = [question.tx, question.rx].map(DVec2::from);
        let view = LinkView::traced(from, to, &link.paths).from_heading(question.label.heading_deg);
        Ok(Self {
            city,
            link,
            view,
            times,
        })
    }
}

/// The answer about a link.
#[derive(Debug, Serialize)]
pub struct Answer {
    link: LinkEntry,
    /// Turn that takes an angle of the spectrum into the direction on the map that the path comes from \[deg\].
    turn_deg: f64,
    distance_m: f64,
    line_of_sight: bool,
    is_enclosed: bool,
    path_loss_db: Option<f64>,
    delay_spread_ns: Option<f64>,
    omitted: usize,
    spectrum: Option<Curve>,
    other: Option<Curve>,
    /// Curve of the shipped model, if it is asked for and there is a label to hold it against.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<Prediction>,
    has_mirrors: bool,
    columns: [&'static [&'static str]; 2],
    lobes: Vec<LobeAnswer>,
    paths: Vec<PathAnswer>,
    times_us: Times,
}

#[derive(Debug, Serialize)]
struct LobeAnswer {
    angle_deg: f64,
    level_db: f64,
    /// Name of the side, by [`Side::name`](aps_report::link::Side::name).
    side: &'static str,
    twin: Option<usize>,
    /// Number and colour of the path that makes it.
    path: Option<usize>,
    colour: String,
    cells: Vec<String>,
}

#[derive(Debug, Serialize)]
struct PathAnswer {
    /// Place among the paths of the link.
    index: usize,
    number: usize,
    colour: String,
    /// The angle at which the spectrum shows it \[deg\].
    angle_deg: f64,
    /// Angle of its mirror image, if the array makes one \[deg\].
    mirror_deg: Option<f64>,
    gain_db: f64,
    delay_ns: f64,
    cells: Vec<String>,
}

/// Angle of a spectrum to direction on the map \[deg\].
pub fn turn_deg(label: &LabelChoice) -> f64 {
    aps_report::link::turn_deg(label.protocol) + label.heading_deg
}

/// Answers a question about a link.
///
/// # Errors
/// As [`Traced::new`], and paths that make no label.
pub fn answer(
    cache: &Cache,
    question: &LinkQuestion,
    handle: &RequestHandle,
) -> Result<Answer, Fault> {
    let label = question.label.config()?;
    let mut traced = Traced::new(cache, question, handle)?;
    let began = Instant::now();
    let protocol = question.label.protocol;
    let explanation = Explanation::of(&traced.view, protocol, &label)?;
    traced.times.label = us(began.elapsed());
    let shown = explanation.as_ref().filter(|_| question.model);
    let model = shown.map(|e| Prediction::of(cache, &traced.city, question, &e.spectrum));
    let model = model.transpose()?;
    let view = &traced.view;
    let index = |path: &PathView| view.paths.iter().position(|p| std::ptr::eq(p, path));
    let (mut lobes, mut paths) = (Vec::new(), Vec::new());
    if let Some(e) = &explanation {
        for (lobe, (cells, cause)) in e.lobes.iter().zip(e.lobe_rows()) {
            lobes.push(LobeAnswer {
                angle_deg: lobe.angle_deg,
                level_db: lobe.level_db,
                side: lobe.side.name(),
                twin: lobe.twin,
                path: cause.map(|l| l.number),
                colour: cause.map_or("soft".into(), |l| l.colour.to_string()),
                cells,
            });
        }
        for (cells, listed) in e.path_rows() {
            let path = listed.path;
            let own_deg = angle_deg(path.arrival_azimuth_rad, protocol);
            paths.push(PathAnswer {
                index: index(path).unwrap_or_default(),
                number: listed.number,
                colour: listed.colour.to_string(),
                angle_deg: own_deg,
                mirror_deg: e.has_mirrors.then(|| mirror_deg(own_deg)),
                gain_db: path.gain_db,
                delay_ns: path.delay_s * 1e9,
                cells,
            });
        }
    }
    let curve = |s: &Spectrum| Curve::of(s, protocol);
    let other = explanation.as_ref().and_then(|e| e.other.as_ref());
    Ok(Answer {
        link: LinkEntry::new(view.tx, view.rx, &traced.link.paths),
        turn_deg: turn_deg(&question.label),
        distance_m: view.distance_m(),
        line_of_sight: view.has_line_of_sight(),
        is_enclosed: traced.link.is_enclosed,
        path_loss_db: view.path_loss_db(),
        delay_spread_ns: view.delay_spread_s().map(|s| s * 1e9),
        omitted: traced.link.omitted.by_bound + traced.link.omitted.by_gain,
        spectrum: explanation.as_ref().map(|e| curve(&e.spectrum)),
        other: other.map(curve),
        model,
        has_mirrors: explanation.as_ref().is_some_and(|e| e.has_mirrors),
        columns: [&LOBE_COLUMNS, &PATH_COLUMNS],
        lobes,
        paths,
        times_us: traced.times,
    })
}
