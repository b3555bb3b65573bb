//! One link of the gallery: map, spectra, delay profile.

use aps_label::{LabelConfig, Labeler, Protocol};

use crate::ReportError;
use crate::chart::Series;
use crate::document::{Block, Figure, Layout, Section};
use crate::drawing::Drawing;
use crate::link::{LinkView, Spectrum, has_mirrors};
use crate::picture::{self, GainScale, Outlines, Ray};
use crate::theme::Colour;

/// Both protocols, each in its colour; the first lies below. The dashed one is above: where both agree, either is seen.
const PROTOCOLS: [(Protocol, Colour); 2] = [
    (Protocol::Paper, Colour::Ink),
    (Protocol::Released, Colour::Series(1)),
];

/// End of the delay profiles of both protocols \[ns\].
const PROFILE_NS: f64 = 1000.0;

/// A reading of the pictures of links whose paths are known, or of those whose stored labels alone are.
pub fn legend(label: &LabelConfig, has_paths: bool) -> String {
    let mirrors = match has_mirrors(label) {
        true => {
            " A path makes a second lobe at 180 deg minus its own angle, because the array knows directions by their sine only."
        }
        false => "",
    };
    if !has_paths {
        let protocol = label.protocol;
        return format!(
            "Paths are not known: the map shows buildings and terminals alone. The curves are the stored ones, of the {protocol} \
             definition, over the power sent and by the angle of arrival.{mirrors}"
        );
    }
    let dashed = match has_mirrors(label) {
        true => ", dashed ones their mirror images",
        false => "",
    };
    format!(
        "The map shows all paths, the stronger the brighter and wider; open dots are reflections, filled dots diffractions. \
         The spectra are those of the paper's definition (solid) and of the released code (dashed), over the power sent and \
         by the angle of arrival; stems are the paths{dashed}.{mirrors} Where the two curves differ, the released code's coarse delays \
         miss the top of the pulse, or the path comes later than they reach."
    )
}

/// A link, with everything that is shown of it.
#[derive(Debug)]
pub struct LinkPanel<'a> {
    /// Name of the link.
    pub title: String,
    /// The buildings.
    pub outlines: &'a Outlines,
    /// The link; without paths if they are unknown.
    pub link: &'a LinkView,
    /// Settings of the labels made from the paths.
    pub label: &'a LabelConfig,
    /// Reason for which the link has no label.
    pub no_label: Option<String>,
    /// The paths are known.
    pub has_paths: bool,
    /// Diffractions of a link beyond the tracer's limits; 0 for others.
    pub fallback: u8,
    /// The stored spectrum, shown where there are no paths; empty arrays for what is not stored.
    pub stored: Option<Spectrum>,
}

impl LinkPanel<'_> {
    /// Adds the link to a page.
    ///
    /// # Errors
    /// Paths that cannot be labelled.
    pub fn show(&self, section: &mut Section) -> Result<(), ReportError> {
        section.heading(&self.title);
        section.text(self.facts());
        let link = self.link;
        let scale = GainScale::over(&link.paths);
        let rays = picture::rays_by_gain(link, &scale);
        let city = picture::map(self.outlines, link, &rays, 480.0);
        let (caption, [aps, pdp]) = match (link.paths.is_empty(), &self.stored) {
            (false, _) => {
                let strongest_db = scale.strongest_db();
                let caption = format!("The strongest path has a gain of {strongest_db:.1} dB.");
                (caption, labelled(self.label, link, &scale)?)
            }
            (true, Some(spectrum)) => (String::new(), stored(spectrum)),
            (true, None) => (String::new(), [None, None]),
        };
        let figure = |caption: &str, drawing| Block::Figure(Figure::shown(caption, drawing));
        let aps = aps.map(|drawing| figure("Angle power spectrum.", drawing));
        let pdp = pdp.map(|drawing| {
            figure(
                "Power delay profile; of a curve finer than the picture the upper envelope.",
                drawing,
            )
        });
        let blocks = vec![
            figure(&caption, city),
            Block::Group(Layout::Stack, aps.into_iter().chain(pdp).collect()),
        ];
        section.blocks.push(Block::Group(Layout::Beside, blocks));
        Ok(())
    }

    fn facts(&self) -> String {
        let link = self.link;
        let mut facts = vec![format!("{:.0} m", link.distance_m())];
        facts.extend(self.no_label.as_ref().map(|why| format!("no label: {why}")));
        if self.has_paths {
            let sight = match link.has_line_of_sight() {
                true => "line of sight",
                false => "no line of sight",
            };
            facts.push(format!("{sight}, {} paths", link.paths.len()));
        } else {
            facts.push("paths are not stored".into());
        }
        if let Some(loss) = link.path_loss_db() {
            facts.push(format!("path loss {loss:.1} dB"));
        }
        if let Some(spread) = link.delay_spread_s() {
            facts.push(format!("delay spread {:.0} ns", spread * 1e9));
        }
        if self.fallback > 0 {
            let most = self.fallback;
            facts.push(format!("beyond the tracer's limits: {most} diffractions"));
        }
        facts.join(", ") + "."
    }
}

/// Draws the spectra and delay profiles of the paths, under both protocols.
fn labelled(
    label: &LabelConfig,
    link: &LinkView,
    scale: &GainScale,
) -> Result<[Option<Drawing>; 2], ReportError> {
    let samples = link.samples();
    let mut spectra = Vec::new();
    for (protocol, colour) in PROTOCOLS {
        let config = LabelConfig {
            pdp: true,
            ..label.under(protocol)
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
    aps = picture::stems_by_gain(aps, link, scale, sense, has_mirrors(label));
    for (spectrum, colour) in &spectra {
        aps = aps.with(picture::curve(spectrum, sense, *colour));
    }
    // Paths that come later than the profiles reach are to be seen, unless nobody would see them.
    let weakest_db = top_db - 45.0;
    let delays = link.paths.iter().filter(|p| p.gain_db > weakest_db);
    let latest_ns = delays.map(|p| p.delay_s * 1e9).fold(PROFILE_NS, f64::max);
    let last_ns = (latest_ns / 100.0).ceil() * 100.0;
    let mut pdp = picture::delay_chart(last_ns, &spectra).sized(480.0, 250.0);
    let stem = |ray: Ray<'_>| {
        let tip = [ray.path.delay_s * 1e9, ray.path.gain_db];
        Series::stem(ray.colour, tip, false)
    };
    let stems = picture::rays_by_gain(link, scale).into_iter().map(stem);
    pdp.series.splice(0..0, stems);
    Ok([Some(aps.draw()), Some(pdp.draw())])
}

/// Draws the stored spectrum and delay profile, where there are no paths.
fn stored(spectrum: &Spectrum) -> [Option<Drawing>; 2] {
    let aps = (!spectrum.aps_db.is_empty()).then(|| {
        let axes = picture::axes(Protocol::Paper, spectrum.top_db(), false).sized(480.0, 270.0);
        axes.with(picture::curve(spectrum, Protocol::Paper, Colour::Ink))
            .draw()
    });
    let pdp = (!spectrum.pdp.is_empty()).then(|| {
        let chart = picture::delay_chart(PROFILE_NS, &[(spectrum.clone(), Colour::Ink)]);
        chart.sized(480.0, 250.0).draw()
    });
    [aps, pdp]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_tells_of_nothing_that_is_not_drawn() {
        let label = LabelConfig::released();
        let known = legend(&label, true);
        assert!(known.contains("stems") && known.contains("dashed") && known.contains("lobe"));
        let stored = legend(&label, false);
        assert!(!stored.contains("stems") && !stored.contains("dashed"));
        assert!(stored.contains("released definition"), "{stored}");
        let circular = LabelConfig {
            array: aps_label::Array::UniformCircular {
                elements: 16,
                radius_wavelengths: 1.0,
            },
            ..label
        };
        assert!(!legend(&circular, true).contains("second lobe"));
    }
}
