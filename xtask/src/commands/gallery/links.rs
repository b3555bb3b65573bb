//! One link of the gallery: map, spectra, delay profile.

use anyhow::Result;
use aps_label::{LabelConfig, Labeler, Protocol};
use aps_report::chart::{Mark, Series};
use aps_report::document::{Block, Figure, Layout, Section};
use aps_report::drawing::Drawing;
use aps_report::link::{LinkView, Spectrum};
use aps_report::picture::{self, GainScale};
use aps_report::theme::Colour;

use crate::source::{Source, SourceMap};

/// Both protocols, each in its colour; the first lies below.
const PROTOCOLS: [(Protocol, Colour); 2] = [
    (Protocol::Released, Colour::Series(1)),
    (Protocol::Paper, Colour::Ink),
];

/// End of the delay profiles of both protocols \[ns\].
const PROFILE_NS: f64 = 1000.0;

/// A reading of the pictures, for all links.
pub const LEGEND: &str = "The map shows all paths, the stronger the brighter and wider; open dots are reflections, filled dots \
     diffractions. The spectra are those of the paper's definition (solid) and of the released code (dashed), \
     over the power sent and by the angle of arrival; stems are the paths. A path makes a second lobe at 180 deg \
     minus its own angle, because the array knows directions by their sine only. Where the two curves differ, the \
     released code's coarse delays miss the top of the pulse, or the path comes later than they reach.";

/// Adds a link to the page.
pub fn exhibit(
    section: &mut Section,
    source: &Source,
    map: &SourceMap,
    row: usize,
    link: &LinkView,
) -> Result<()> {
    let [tx, rx] = map.data.links[row];
    section.heading(format!(
        "Map {}, transmitter {tx}, receiver {rx}",
        map.data.id
    ));
    section.text(facts(map, row, link));
    let scale = GainScale::over(&link.paths);
    let rays = picture::rays_by_gain(link, &scale);
    let city = picture::map(&map.outlines, link, &rays, 480.0);
    let (aps, pdp) = match link.paths.is_empty() {
        true => stored(source, map, row)?,
        false => labelled(source, link, &scale)?,
    };
    let caption = match link.paths.is_empty() {
        true => String::new(),
        false => format!(
            "The strongest path has a gain of {:.1} dB.",
            scale.strongest_db()
        ),
    };
    let spectra = [
        ("Angle power spectrum.", aps),
        ("Power delay profile.", pdp),
    ];
    let spectra = spectra
        .into_iter()
        .filter_map(|(caption, drawing)| Some(Block::Figure(Figure::shown(caption, drawing?))));
    let blocks = vec![
        Block::Figure(Figure::shown(caption, city)),
        Block::Group(Layout::Stack, spectra.collect()),
    ];
    section.blocks.push(Block::Group(Layout::Beside, blocks));
    Ok(())
}

fn facts(map: &SourceMap, row: usize, link: &LinkView) -> String {
    let mut facts = vec![format!("{:.0} m", link.distance_m())];
    let status = map.data.status[row];
    if !status.is_valid() {
        facts.push(format!("no label: {status}"));
    }
    match map.has_paths() {
        false => facts.push("paths are not stored".into()),
        true => {
            let sight = if link.has_line_of_sight() {
                "line of sight"
            } else {
                "no line of sight"
            };
            facts.push(sight.into());
            facts.push(format!("{} paths", link.paths.len()));
        }
    }
    if let Some(loss) = link.path_loss_db() {
        facts.push(format!("path loss {loss:.1} dB"));
    }
    if let Some(spread) = link.delay_spread_s() {
        facts.push(format!("delay spread {:.0} ns", spread * 1e9));
    }
    match map.data.fallback[row] {
        0 => {}
        n => facts.push(format!("beyond the tracer's limits: {n} diffractions")),
    }
    facts.join(", ") + "."
}

/// From the paths, under both protocols.
fn labelled(
    source: &Source,
    link: &LinkView,
    scale: &GainScale,
) -> Result<(Option<Drawing>, Option<Drawing>)> {
    let samples = link.samples();
    let mut spectra = Vec::new();
    for (protocol, colour) in PROTOCOLS {
        let config = LabelConfig {
            pdp: true,
            ..source.label().under(protocol)
        };
        let spectrum = Spectrum::of(&Labeler::new(&config)?, &samples)?;
        spectra.extend(spectrum.map(|s| (s, colour)));
    }
    let top_db = spectra
        .iter()
        .map(|s| s.0.top_db())
        .fold(f64::NEG_INFINITY, f64::max);
    let sense = Protocol::Paper;
    let mut aps = picture::axes(sense, top_db, false).sized(480.0, 270.0);
    aps = picture::stems_by_gain(aps, link, scale, sense);
    for (spectrum, colour) in &spectra {
        aps = aps.with(picture::curve(spectrum, sense, *colour));
    }
    let profiles: Vec<(String, Colour, Vec<[f64; 2]>)> = spectra
        .into_iter()
        .map(|(s, colour)| (s.protocol.to_string(), colour, s.pdp))
        .collect();
    // Paths that come later than the profiles reach are to be seen, unless nobody would see them.
    let weakest_db = top_db - 45.0;
    let delays = link.paths.iter().filter(|p| p.gain_db > weakest_db);
    let latest_ns = delays.map(|p| p.delay_s * 1e9).fold(PROFILE_NS, f64::max);
    let last_ns = (latest_ns / 100.0).ceil() * 100.0;
    let mut pdp = picture::delay_chart(last_ns, &profiles).sized(480.0, 250.0);
    let stems = picture::rays_by_gain(link, scale).into_iter().map(|ray| {
        Series::new(
            "",
            ray.colour,
            Mark::Stems {
                points: vec![[ray.path.delay_s * 1e9, ray.path.gain_db]],
                dashed: false,
            },
        )
    });
    pdp.series.splice(0..0, stems);
    Ok((Some(aps.draw()), Some(pdp.draw())))
}

/// As stored, where there are no paths.
fn stored(
    source: &Source,
    map: &SourceMap,
    row: usize,
) -> Result<(Option<Drawing>, Option<Drawing>)> {
    let protocol = source.label().protocol;
    let sent_db = protocol.sent_power_db();
    let layout = source.dataset().manifest().layout;
    if !map.data.status[row].is_valid() {
        return Ok((None, None));
    }
    let read = |profile: &aps_data::Profile| -> Vec<f64> {
        let mut relative = vec![0.0; profile.bins()];
        profile.read_relative_db(row, &mut relative);
        let top_db = f64::from(profile.max_db()[row]) - sent_db;
        relative.iter().map(|&db| top_db + f64::from(db)).collect()
    };
    let aps = map
        .data
        .aps
        .as_ref()
        .zip(layout.aps)
        .map(|(profile, layout)| {
            let spectrum = Spectrum {
                protocol,
                angles_deg: layout.axis.values().collect(),
                aps_db: read(profile),
                delay_s: Vec::new(),
                pdp: Vec::new(),
            };
            let chart =
                picture::axes(Protocol::Paper, spectrum.top_db(), false).sized(480.0, 270.0);
            chart
                .with(picture::curve(&spectrum, Protocol::Paper, Colour::Ink))
                .draw()
        });
    let pdp = match layout.pdp {
        None => None,
        Some(layout) => {
            let profile = source.dataset().pdp(map.data.id)?;
            let points = layout
                .axis
                .values()
                .zip(read(&profile))
                .map(|(ns, db)| [ns, db]);
            let profiles = [(protocol.to_string(), Colour::Ink, points.collect())];
            Some(
                picture::delay_chart(PROFILE_NS, &profiles)
                    .sized(480.0, 250.0)
                    .draw(),
            )
        }
    };
    Ok((aps, pdp))
}
