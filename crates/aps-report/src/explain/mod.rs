//! Explanations of a link: its lobes, the paths worth naming, the loss of each where delays are sampled; as a page and as one picture.

mod render;

use aps_label::{LabelConfig, Labeler, Protocol};

pub use render::Explained;

use crate::ReportError;
use crate::link::{
    LinkView, Lobe, PathView, SampledLoss, Side, Spectrum, angle_deg, has_mirrors, lobes,
    sampled_loss,
};
use crate::numbers::fixed;
use crate::theme::Colour;

/// Paths in the table, unless more make lobes.
const LISTED: usize = 12;

/// A link explained under one protocol.
#[derive(Debug)]
pub struct Explanation<'a> {
    /// The link.
    pub link: &'a LinkView,
    /// Its spectrum.
    pub spectrum: Spectrum,
    /// Its spectrum under the other protocol; none if that counts no path.
    pub other: Option<Spectrum>,
    /// Its dominant peaks, by ascending angle.
    pub lobes: Vec<Lobe>,
    /// Its paths worth naming, strongest first.
    pub listed: Vec<Listed<'a>>,
    /// The array shows each path twice.
    pub has_mirrors: bool,
}

/// A path in the table.
#[derive(Debug)]
pub struct Listed<'a> {
    /// The path.
    pub path: &'a PathView,
    /// Its place among all paths by gain, from 1.
    pub number: usize,
    /// A colour of its own if it makes a lobe.
    pub colour: Colour,
    /// Largest share of a lobe where the path comes from, and of a mirror lobe.
    pub shares: [f64; 2],
    /// Its loss in the released label.
    pub sampled_loss: SampledLoss,
}

impl<'a> Explanation<'a> {
    /// Explains a link; none if the protocol counts no path of the link.
    pub fn of(
        link: &'a LinkView,
        protocol: Protocol,
        base: &LabelConfig,
    ) -> Result<Option<Self>, ReportError> {
        let labeler = Labeler::new(&base.under(protocol))?;
        let samples = link.samples();
        let Some(spectrum) = Spectrum::of(&labeler, &samples)? else {
            return Ok(None);
        };
        let other = Labeler::new(&base.under(match protocol {
            Protocol::Released => Protocol::Paper,
            Protocol::Paper => Protocol::Released,
        }))?;
        let released = match protocol {
            Protocol::Released => &labeler,
            Protocol::Paper => &other,
        };
        let lobes = lobes(&labeler, &samples, &spectrum)?;

        let mut by_gain: Vec<usize> = (0..samples.len()).collect();
        by_gain.sort_by(|&i, &j| samples[j].gain_db.total_cmp(&samples[i].gain_db));
        let is_leading = |i: usize| lobes.iter().any(|lobe| lobe.leading().any(|s| s.0 == i));
        let mut colours = (0..).map(Colour::Series);
        let mut listed = Vec::new();
        for (place, &i) in by_gain.iter().enumerate() {
            let leads = is_leading(i);
            if !leads && place >= LISTED {
                continue;
            }
            let own = angle_deg(samples[i].arrival_azimuth_rad, protocol);
            let share = |side: Side| {
                let is_of = |l: &&Lobe| Side::of(&labeler.config().array, l.angle_deg, own) == side;
                let of = lobes.iter().filter(is_of);
                of.map(|l| l.share_of(i)).fold(0.0, f64::max)
            };
            listed.push(Listed {
                path: &link.paths[i],
                number: place + 1,
                colour: match leads {
                    true => colours.next().expect("there is always another"),
                    false => Colour::Soft,
                },
                shares: [share(Side::Own), share(Side::Mirror)],
                sampled_loss: sampled_loss(released, &samples[i])?,
            });
        }
        Ok(Some(Self {
            link,
            other: Spectrum::of(&other, &samples)?,
            spectrum,
            lobes,
            listed,
            has_mirrors: has_mirrors(labeler.config()),
        }))
    }

    /// The path in the table that `index` of the link is.
    fn listed(&self, index: usize) -> Option<&Listed<'a>> {
        let path = &self.link.paths[index];
        self.listed.iter().find(|l| std::ptr::eq(l.path, path))
    }

    /// Rows of the table of lobes, their cells in the order of [`LOBE_COLUMNS`], each with the path that makes the lobe.
    pub fn lobe_rows(&self) -> Vec<(Vec<String>, Option<&Listed<'a>>)> {
        let row = |lobe: &Lobe| {
            let named = |(i, share): (usize, f64)| {
                let number = self.listed(i).map_or(0, |l| l.number);
                format!("path {number} ({:.0} %)", 100.0 * share)
            };
            let leading: Vec<String> = lobe.leading().map(named).collect();
            let cause = lobe.cause().and_then(|i| self.listed(i));
            let text = match (cause, leading.is_empty()) {
                (Some(_), _) => leading.join(", with "),
                (None, false) => format!("no single path: {}", leading.join(", ")),
                (None, true) => "no single path: many weak ones".into(),
            };
            let side = match (cause, lobe.side) {
                (Some(_), Side::Mirror) => "mirror image",
                (Some(_), Side::Grating) => "grating lobe",
                (Some(_), Side::Sidelobe) => "sidelobe",
                (Some(_), Side::Own) => "where it comes from",
                (None, _) => "\u{2013}",
            };
            let mirror_deg = lobe.mirror_deg().filter(|_| self.has_mirrors);
            let twin = match (lobe.twin, mirror_deg) {
                (Some(j), _) => degrees(self.lobes[j].angle_deg),
                (None, Some(mirror)) => format!("{}, no dominant peak", degrees(mirror)),
                (None, None) => "\u{2013}".into(),
            };
            let mark = match cause {
                Some(l) => badge_text(l.number, lobe.side),
                None => "?".into(),
            };
            let cells = vec![
                mark,
                degrees(lobe.angle_deg),
                fixed(lobe.level_db, 1),
                text,
                side.into(),
                twin,
            ];
            (cells, cause)
        };
        self.lobes.iter().map(row).collect()
    }

    /// Rows of the table of paths, their cells in the order of [`PATH_COLUMNS`].
    pub fn path_rows(&self) -> Vec<(Vec<String>, &Listed<'a>)> {
        let row = |l: &'_ Listed<'a>| {
            vec![
                l.number.to_string(),
                l.path.name(),
                fixed(l.path.length_m(), 1),
                fixed(l.path.delay_s * 1e9, 1),
                fixed(angle_deg(l.path.arrival_azimuth_rad, Protocol::Paper), 1),
                fixed(l.path.gain_db, 1),
                percent(l.shares[0]),
                percent(l.shares[1]),
                loss_text(l.sampled_loss),
            ]
        };
        self.listed.iter().map(|l| (row(l), l)).collect()
    }
}

/// Columns of [`Explanation::lobe_rows`].
pub const LOBE_COLUMNS: [&str; 6] = [
    "lobe",
    "at [deg]",
    "level [dB]",
    "made by",
    "it is",
    "mirror lobe at",
];

/// Columns of [`Explanation::path_rows`].
pub const PATH_COLUMNS: [&str; 9] = [
    "path",
    "interactions",
    "length [m]",
    "delay [ns]",
    "arrival [deg]",
    "gain [dB]",
    "of its lobe",
    "of the mirror",
    "in the released label",
];

/// A path's number, with a prime at its mirror lobe, and two at a grating lobe or a sidelobe.
fn badge_text(number: usize, side: Side) -> String {
    let primes = match side {
        Side::Own => "",
        Side::Mirror => "\u{2032}",
        Side::Grating | Side::Sidelobe => "\u{2033}",
    };
    format!("{number}{primes}")
}

fn degrees(value: f64) -> String {
    fixed(value, 0)
}

fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p >= 0.5 => format!("{p:.0} %"),
        _ => "\u{2013}".into(),
    }
}

fn loss_text(loss: SampledLoss) -> String {
    match loss {
        SampledLoss::Sampled { lost_db } if lost_db < 0.05 => "whole, on a grid delay".into(),
        SampledLoss::Sampled { lost_db } => format!("\u{2212}{lost_db:.1} dB, between grid delays"),
        SampledLoss::Beyond { last_ns, lost_db } => {
            format!("disappears: \u{2212}{lost_db:.0} dB, beyond {last_ns:.0} ns")
        }
        SampledLoss::Dropped { loss_db } if loss_db > 0.0 => {
            format!("dropped: loss {loss_db:.0} dB is above 310 dB")
        }
        SampledLoss::Dropped { .. } => "dropped: no loss".into(),
    }
}
