//! One set of colours for pages and pictures, light and dark.
//!
//! Every colour has a name and two values. In a page a name is a CSS variable, which follows the
//! reader's theme; in a picture that stands alone as a file it is written out in its light value,
//! since viewers other than browsers know no variables.
//!
//! The first three series colours are blue, vermilion and green of Okabe and Ito, "Color Universal
//! Design" (2008), lightened for dark pages. The others were searched for, one in each of five hues,
//! so that any two differ by at least 20 in CIE L*a*b* for normal, red-blind and green-blind sight.

use std::fmt;

/// Name, value on a light page, value on a dark page.
const TOKENS: [(&str, &str, &str); 27] = [
    ("paper", "#ffffff", "#14171c"),
    ("panel", "#f4f5f7", "#1c2128"),
    ("ink", "#1d232b", "#e6eaf0"),
    ("soft", "#5b6572", "#9ba6b4"),
    ("grid", "#e3e6ea", "#2b323b"),
    ("edge", "#9aa3ad", "#596472"),
    ("accent", "#0b62a4", "#6db8f2"),
    ("ground", "#f6f4ef", "#1a1e24"),
    ("house", "#d3cdc1", "#39414c"),
    ("wall", "#8d8574", "#6b7684"),
    ("bend", "#ffffff", "#14171c"),
    ("s1", "#0072b2", "#4fb0f0"),
    ("s2", "#d55e00", "#ff8f4d"),
    ("s3", "#009e73", "#35cf9f"),
    ("s4", "#cf13f7", "#ab6193"),
    ("s5", "#6e5a2a", "#f8ec2d"),
    ("s6", "#441289", "#6572fb"),
    ("s7", "#581f23", "#de3653"),
    ("s8", "#00a8c0", "#80f898"),
    ("g0", "#440154", "#5a4a78"),
    ("g1", "#433e85", "#5f64a6"),
    ("g2", "#31688e", "#4e83ad"),
    ("g3", "#218f8d", "#36a3a2"),
    ("g4", "#35b779", "#43bf85"),
    ("g5", "#7fc93c", "#97d84f"),
    ("g6", "#d1b915", "#d8dc3a"),
    ("g7", "#fd9a1f", "#ffe35a"),
];

/// Number of different series colours; further series repeat them.
pub const SERIES_COLOURS: usize = 8;

/// Number of steps of the scale of strengths.
pub const STRENGTH_STEPS: usize = 8;

/// The style of pictures, in the names of the colours.
const PICTURE_CSS: &str = "\
.picture text{font:13px system-ui,sans-serif;fill:var(--ink)}
.picture .small{font-size:11.5px;fill:var(--soft)}
.picture .title{font-size:15px;font-weight:600}
.picture .halo{paint-order:stroke;stroke:var(--paper);stroke-width:4px;stroke-linejoin:round}
.picture .number{font-size:11px;font-weight:700;fill:var(--paper)}
.picture .hollow .number{fill:var(--ink)}
.picture .line{fill:none;stroke-linejoin:round;stroke-linecap:round;stroke-width:1.8}
.picture .dashed{stroke-dasharray:5 4}
.picture .grid{stroke:var(--grid);fill:none}
.picture .frame{stroke:var(--edge);fill:none}
.picture .paper{fill:var(--paper)}
.picture .ground{fill:var(--ground)}
.picture .house{fill:var(--house);stroke:var(--wall);stroke-width:.8;fill-rule:evenodd}
.picture .bend{stroke:var(--ink);stroke-width:.7}
.picture .reflection{fill:var(--bend)}
.picture .diffraction{fill:var(--ink)}
";

/// A colour by its part in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// Colour of text: for the truth and the main thing.
    Ink,
    /// Colour of secondary text: for things to compare with.
    Soft,
    /// Colour of series 0, 1, ...; repeats after [`SERIES_COLOURS`].
    Series(usize),
    /// Colour of a step of the scale of strengths, 0 the weakest; beyond [`STRENGTH_STEPS`] the strongest.
    Strength(usize),
}

impl Colour {
    /// A step of the scale of strengths from a part of its range, 0 to 1.
    pub fn strength(part: f64) -> Self {
        let step = part.clamp(0.0, 1.0) * (STRENGTH_STEPS - 1) as f64;
        Self::Strength(step.round() as usize)
    }

    /// The class that draws lines in this colour.
    pub fn stroke(self) -> String {
        format!("stroke-{self}")
    }

    /// The class that fills with this colour.
    pub fn fill(self) -> String {
        format!("fill-{self}")
    }
}

/// The name of its token.
impl fmt::Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Ink => f.write_str("ink"),
            Self::Soft => f.write_str("soft"),
            Self::Series(i) => write!(f, "s{}", i % SERIES_COLOURS + 1),
            Self::Strength(i) => write!(f, "g{}", i.min(STRENGTH_STEPS - 1)),
        }
    }
}

/// Style of pictures inside a page: rules over the variables of [`variables_css`].
pub fn picture_css() -> String {
    let mut css = String::from(PICTURE_CSS);
    let series = (0..SERIES_COLOURS).map(Colour::Series);
    let strengths = (0..STRENGTH_STEPS).map(Colour::Strength);
    // An id before the classes, so that a text's colour wins over that of all text.
    for colour in [Colour::Ink, Colour::Soft]
        .into_iter()
        .chain(series)
        .chain(strengths)
    {
        css += &format!(
            ".picture .fill-{colour},.picture text.fill-{colour}{{fill:var(--{colour})}}\
             .picture .stroke-{colour}{{stroke:var(--{colour})}}\n"
        );
    }
    css
}

/// Styles for a picture that stands alone: light colours, no variables.
pub fn standalone_css() -> String {
    TOKENS.iter().fold(picture_css(), |css, (name, light, _)| {
        css.replace(&format!("var(--{name})"), light)
    })
}

/// The variables: light ones, and dark ones where the reader prefers them.
pub fn variables_css() -> String {
    let list =
        |pick: fn(&(&str, &str, &str)) -> String| -> String { TOKENS.iter().map(pick).collect() };
    let light = list(|(name, light, _)| format!("--{name}:{light};"));
    let dark = list(|(name, _, dark)| format!("--{name}:{dark};"));
    format!(
        ":root{{color-scheme:light dark;{light}}}\n@media(prefers-color-scheme:dark){{:root{{{dark}}}}}\n"
    )
}

#[cfg(test)]
mod tests {
    use aps_raytrace::glam::{DMat3, DVec3, dvec3};

    use super::*;

    #[test]
    fn pictures_that_stand_alone_know_no_variables() {
        let css = standalone_css();
        assert!(!css.contains("var("), "{css}");
        assert!(css.contains("#0072b2"));
    }

    #[test]
    fn every_colour_used_has_a_value_in_both_themes() {
        let (css, variables) = (picture_css(), variables_css());
        for used in css.split("var(").skip(1) {
            let name = used.split(')').next().unwrap();
            assert_eq!(variables.matches(&format!("{name}:")).count(), 2, "{name}");
        }
    }

    /// Linear red, green and blue of `#rrggbb`.
    fn linear(hex: &str) -> DVec3 {
        let part = |i: usize| {
            let c = f64::from(u8::from_str_radix(&hex[i..i + 2], 16).unwrap()) / 255.0;
            match c <= 0.04045 {
                true => c / 12.92,
                false => ((c + 0.055) / 1.055).powf(2.4),
            }
        };
        [1, 3, 5].map(part).into()
    }

    /// CIE L*a*b* of linear sRGB, white D65.
    fn lab(rgb: DVec3) -> DVec3 {
        let xyz = DMat3::from_cols(
            dvec3(0.4124, 0.2126, 0.0193),
            dvec3(0.3576, 0.7152, 0.1192),
            dvec3(0.1805, 0.0722, 0.9505),
        );
        let f = |t: f64| match t > 0.008856 {
            true => t.cbrt(),
            false => 7.787 * t + 16.0 / 116.0,
        };
        let white = dvec3(0.9505, 1.0, 1.089);
        let [x, y, z] = (xyz * rgb.clamp(DVec3::ZERO, DVec3::ONE) / white)
            .to_array()
            .map(f);
        dvec3(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    }

    #[test]
    fn series_differ_for_those_who_see_no_red_or_no_green() {
        // Machado, Oliveira, Fernandes, "A physiologically-based model for simulation of color
        // vision deficiency" (2009), severity 1.
        let sights = [
            DMat3::IDENTITY,
            DMat3::from_cols(
                dvec3(0.152286, 0.114503, -0.003882),
                dvec3(1.052583, 0.786281, -0.048116),
                dvec3(-0.204868, 0.099216, 1.051998),
            ),
            DMat3::from_cols(
                dvec3(0.367322, 0.280085, -0.011820),
                dvec3(0.860646, 0.672501, 0.042940),
                dvec3(-0.227968, 0.047413, 0.968881),
            ),
        ];
        let is_series = |t: &&(&str, &str, &str)| t.0.starts_with('s') && t.0.len() == 2;
        let series: Vec<_> = TOKENS.iter().filter(is_series).collect();
        assert_eq!(series.len(), SERIES_COLOURS);
        for sight in sights {
            for (i, a) in series.iter().enumerate() {
                for b in &series[..i] {
                    for (p, q) in [(a.1, b.1), (a.2, b.2)] {
                        let apart = lab(sight * linear(p)).distance(lab(sight * linear(q)));
                        assert!(apart >= 20.0, "{} {p} and {} {q}: {apart:.1}", a.0, b.0);
                    }
                }
            }
        }
    }
}
