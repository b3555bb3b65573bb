//! One set of colours for pages and pictures, light and dark.
//!
//! Every colour has a name and two values. In a page a name is a CSS variable, which follows the
//! reader's theme; in a picture that stands alone as a file it is written out in its light value,
//! since viewers other than browsers know no variables.
//!
//! Series colours follow Okabe and Ito, "Color Universal Design" (2008), for readers who do not see
//! red and green apart, darkened on white and lightened on black until lines stand out from both.

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
    ("s4", "#b04a8f", "#e493c6"),
    ("s5", "#a67c00", "#f2cf4a"),
    ("s6", "#2b2f77", "#a9aef5"),
    ("s7", "#7a1f3d", "#f07f95"),
    ("s8", "#6b7280", "#a6afbb"),
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

/// What pictures look like, in the names of the colours.
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
    /// That of text: the truth, the main thing.
    Ink,
    /// That of secondary text: what is there for comparison.
    Soft,
    /// Series number 0, 1, ...; repeats after [`SERIES_COLOURS`].
    Series(usize),
    /// Step of the scale of strengths, 0 the weakest; beyond [`STRENGTH_STEPS`] the strongest.
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

/// The same for a picture that stands alone: light colours, no variables.
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
}
