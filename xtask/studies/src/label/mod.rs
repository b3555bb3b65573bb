//! Study of the label: errors and times of its delay axis.

mod axis;

use anyhow::{Result, ensure};
use aps_data::sample_of;
use aps_label::PathSample;
use aps_raytrace::scene::CityConfig;
use aps_raytrace::{Link, Receiver, Scene, TraceConfig, Tracer};
use map2aps::sampling::draw as draw_terminals;

use super::{Setup, Study, StudyName};

/// Paths beyond this delay [s] are left out: the studied axes end at 1000 ns, and what they lose there is not a matter
/// of their points.
const LAST_S: f64 = 0.95e-6;

/// Measures.
pub fn run(setup: &Setup) -> Result<Study> {
    let links = links(setup)?;
    let paths = links.iter().map(Vec::len).sum::<usize>() as f64 / links.len() as f64;
    let mut study = StudyName::Label.study("Label: the delay axis");
    study.section.text(format!(
        "{} links of a synthetic city, R2 D1, {paths:.1} paths a link up to {:.0} ns.",
        links.len(),
        1e9 * LAST_S
    ));
    axis::study(setup, &links, &mut study)?;
    Ok(study)
}

/// Traced links, each with a path.
fn links(setup: &Setup) -> Result<Vec<Vec<PathSample>>> {
    let city = CityConfig {
        seed: setup.seed,
        ..CityConfig::default()
    };
    let scene = Scene::synthetic(&city)?;
    let (tx, rx) = setup.profile.choose((1, 6), (4, 24));
    let terminals = draw_terminals(&scene, setup.seed, 0, tx, rx..=rx)?;
    let tracer = Tracer::new(&scene, TraceConfig::default())?;
    let rx: Vec<Receiver> = terminals
        .rx
        .iter()
        .map(|&p| tracer.receiver(p))
        .collect::<Result<_, _>>()?;
    let mut links = Vec::new();
    let mut link = Link::default();
    for &p in &terminals.tx {
        let tx = tracer.transmitter(p)?;
        for rx in &rx {
            tracer.link(&tx, rx, &mut link)?;
            let near = link.paths.iter().filter(|path| path.delay_s < LAST_S);
            let paths: Vec<PathSample> = near.map(sample_of).collect();
            links.extend((!paths.is_empty()).then_some(paths));
        }
    }
    ensure!(
        !links.is_empty(),
        "no link of the synthetic city has a path"
    );
    Ok(links)
}
